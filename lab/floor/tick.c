/* The floor beside the control tick: the least that still is a six-step drive, by hand.
 *
 * Two ticks of 100 us, in whole numbers: with hall sensors, and without by zero crossings of the back-EMF. Both check current and voltage,
 * measure speed over an electrical revolution, and run a speed PI at 1 kHz, a current limit every tick, volts to duty by the live bus, and a
 * slew limit. One direction, one fault, compiled-in gains; no start, no interpolation between hall edges, no status, no parameters.
 *
 * Usage: tick MILLIHERTZ TICKS, the motor's electrical speed and how long it turns. Prints `floor NAME TICKS TOTAL WORST`, instructions under
 * `-icount shift=7`, counted as firmware/src/boards/qemu/instructions.rs does; or `error NAME WHY` where a tick did not do its work.
 */
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

enum { A, B, C, COAST = 6 };

/* What the converter and the edge capture give. Voltages have one scale, 625/32 mV a code; current is 8 mA a code above 2048. */
struct samples {
    uint16_t bus_voltage, bus_current;
    uint16_t phase_voltage[3]; /* in the middle of the on-time */
    uint8_t hall;              /* bit 0 = A, bit 1 = B, bit 2 = C */
    bool edge;                 /* a hall line changed in the period that ended, at `edge_at`, 1/65 536 of it */
    uint16_t edge_at;
};

/* What the timer takes: the step now, and where `next` is another one a commutation at `at`, 1/65 536 of the period. */
struct command {
    uint16_t duty; /* 1/32 768 */
    uint16_t at;
    uint8_t step, next;
};

/* Time in 1/65 536 tick, speed in 1/64 Hz electrical, mV, mA; integrators in 1/256 mV. */
struct drive {
    uint32_t now, last, sum, sector, intervals[6];
    int32_t speed, target, integral, limit, volts, duty;
    uint8_t slot, millisecond;
    bool fault;
    /* Without sensors: the step applied, when it began, and when it ends. */
    uint8_t step, blind;
    bool planned;
    uint32_t began, due;
    int32_t before;
};

typedef void tick(struct drive *, const struct samples *, struct command *);

static const int32_t BUS_MIN = 10000, BUS_MAX = 62000, OVER_CURRENT = 12000, CURRENT_LIMIT = 6000;
static const int32_t SPEED_P = 160, SPEED_I = 4, CURRENT_P = 256, CURRENT_I = 26; /* 1/256 mV of an error of 1 */
static const int32_t DUTY_MIN = 983, DUTY_MAX = 31130, SLEW = 328;                 /* 3, 95 and 1 % */
static const uint32_t TICK = 65536, SHORTEST = 32768, STALL = 5000u * 65536u;
static const uint32_t SPEED_OF_TURN = 2621440000u; /* 64 x 65 536 x 10 kHz / 16 */
enum { BLIND_MAX = 6 };

/* High and low leg of each step, for the feed, and the leg that floats; its back-EMF falls in even steps. */
static const uint8_t HIGH[6] = {A, A, B, B, C, C}, LOW[6] = {B, C, C, A, A, B}, FLOATING[6] = {C, B, A, C, B, A};
static const uint8_t STEP_OF_HALL[8] = {COAST, 1, 3, 2, 5, 0, 4, COAST};

static inline int32_t clamp(int32_t value, int32_t low, int32_t high)
{
    return value < low ? low : value > high ? high : value;
}

/* A sector has ended, at an edge or crossing: mean sector and speed over the last six. */
static inline void take_interval(struct drive *d, uint32_t at)
{
    uint32_t interval = at - d->last;

    interval = interval < SHORTEST ? SHORTEST : interval > STALL ? STALL : interval;
    d->last = at;
    d->sum += interval - d->intervals[d->slot];
    d->intervals[d->slot] = interval;
    d->slot = d->slot == 5 ? 0 : d->slot + 1;
    d->sector = d->sum / 6;
    d->speed = (int32_t)(SPEED_OF_TURN / (d->sum >> 4));
}

static inline int32_t millivolts(uint32_t code)
{
    return (int32_t)(code * 625 >> 5);
}

static inline bool is_sound(int32_t bus, int32_t current)
{
    return bus >= BUS_MIN && bus <= BUS_MAX && current <= OVER_CURRENT && current >= -OVER_CURRENT;
}

/* Speed PI and current limit, the smaller wins; the speed loop's integrator goes no further than the limit. */
static inline int32_t control(struct drive *d, int32_t bus, int32_t current)
{
    int32_t room = CURRENT_LIMIT - current, most, wanted;

    d->limit = clamp(d->limit + room * CURRENT_I, 0, bus << 8);
    most = clamp((d->limit + room * CURRENT_P) >> 8, 0, bus);
    if (++d->millisecond == 10) {
        int32_t error = d->target - d->speed;

        d->millisecond = 0;
        d->integral = clamp(d->integral + error * SPEED_I, 0, most << 8);
        d->volts = (d->integral + error * SPEED_P) >> 8;
    }
    wanted = clamp(d->volts, 0, most);
    wanted = clamp((int32_t)(((uint32_t)wanted << 15) / (uint32_t)bus), DUTY_MIN, DUTY_MAX);
    d->duty = clamp(wanted, d->duty - SLEW, d->duty + SLEW);
    return d->duty;
}

/* The loops' answer, or the bridge off once anything was wrong. */
static inline void answer(struct drive *d, const struct samples *in, uint8_t step, struct command *out)
{
    int32_t bus = millivolts(in->bus_voltage), current = ((int32_t)in->bus_current - 2048) * 8;

    if (d->fault || !is_sound(bus, current)) {
        d->fault = true;
        *out = (struct command){.step = COAST, .next = COAST};
        return;
    }
    out->duty = (uint16_t)control(d, bus, current);
    out->at = 0;
    out->step = out->next = step;
}

__attribute__((noipa)) static void hall(struct drive *d, const struct samples *in, struct command *out)
{
    d->now += TICK;
    if (in->edge) {
        take_interval(d, d->now - TICK + in->edge_at);
    } else if (d->now - d->last > STALL) {
        d->fault = true;
    }
    answer(d, in, STEP_OF_HALL[in->hall & 7], out);
}

/* The crossing of half the bus by the floating phase: 30 degrees later the step ends. Without one it ends after 60 degrees. */
static inline void look_for_crossing(struct drive *d, const struct samples *in)
{
    int32_t beyond = 2 * (int32_t)in->phase_voltage[FLOATING[d->step]] - (int32_t)in->bus_voltage;
    int32_t signal = d->step & 1 ? beyond : -beyond;
    uint32_t since = d->now - d->began;

    if (since < d->sum >> 5) { /* demagnetisation: 11 degrees */
        return;
    }
    if (signal >= 0) {
        uint32_t age = d->before < 0 ? ((uint32_t)signal << 16) / (uint32_t)(signal - d->before) : 0;

        take_interval(d, d->now - age);
        d->due = d->last + (d->sector >> 1);
        d->planned = true;
        d->blind = 0;
    } else if (since + TICK > d->sector) {
        d->due = d->began + d->sector;
        d->last += d->sector;
        d->planned = true;
        d->fault |= ++d->blind > BLIND_MAX;
    }
    d->before = signal;
}

__attribute__((noipa)) static void sensorless(struct drive *d, const struct samples *in, struct command *out)
{
    int32_t left;

    d->now += TICK;
    if (!d->planned) {
        look_for_crossing(d, in);
    }
    answer(d, in, d->step, out);
    left = (int32_t)(d->due - d->now);
    if (d->planned && !d->fault && left < (int32_t)TICK) {
        left = left < 0 ? 0 : left;
        d->began = d->now + (uint32_t)left;
        d->step = d->step == 5 ? 0 : d->step + 1;
        d->planned = false;
        d->before = 0;
        out->at = (uint16_t)left;
        out->next = d->step;
    }
}

/* A drive that has just been handed a motor which turns at this speed, in step 0. */
static struct drive running(uint32_t millihertz, int32_t volts)
{
    struct drive d = {.integral = volts << 8, .volts = volts, .limit = volts << 8, .duty = 16384};

    d.target = d.speed = (int32_t)(millihertz * 64ull / 1000);
    d.sector = (uint32_t)(10000000ull * TICK / (6ull * millihertz));
    d.sum = 6 * d.sector;
    d.last = 0u - d.sector / 2;
    for (int slot = 0; slot < 6; slot++) {
        d.intervals[slot] = d.sector;
    }
    return d;
}

/* What feeds a tick: a rotor at constant speed, x in sixths of an electrical turn, sector x begins where step x should. */
struct feed {
    double x, before, commutated; /* now, a tick ago, and where the last commutation was */
    uint8_t step;
    uint32_t tick, noise;
};

/* A unit trapezoid; x in sixths of a turn, 0 where it begins to be flat. */
static double trapezoid(double x)
{
    while (x >= 6.0) {
        x -= 6.0;
    }
    x = x < 4.0 ? 5.0 - 2.0 * x : 2.0 * x - 11.0;
    return x > 1.0 ? 1.0 : x < -1.0 ? -1.0 : x;
}

/* -1 to 1 and back within `period` ticks. */
static double triangle(uint32_t tick, uint32_t period)
{
    double x = (double)(tick % period) / period;

    return x < 0.5 ? 4.0 * x - 1.0 : 3.0 - 4.0 * x;
}

static uint32_t noise(struct feed *f)
{
    f->noise = f->noise * 1664525u + 1013904223u;
    return f->noise >> 30;
}

/* 18 V with 5 % of ripple, 1 A, a speed that swings by 0.5 %, half the bus as back-EMF, 5 degrees of demagnetisation. */
static struct samples turn(struct feed *f, double hertz)
{
    double bus = 922.0 + 46.0 * triangle(f->tick, 700), emf[3], middle;
    struct samples in = {.bus_voltage = (uint16_t)(bus + noise(f)), .bus_current = (uint16_t)(2172 + noise(f))};
    int sector;

    f->before = f->x;
    f->x += 6e-4 * hertz * (1.0 + 0.005 * triangle(f->tick++, 2000));
    sector = (int)f->x;
    if (sector != (int)f->before) {
        in.edge = true;
        in.edge_at = (uint16_t)(65535.0 * (sector - f->before) / (f->x - f->before));
    }
    sector %= 6;
    in.hall = (uint8_t)((sector < 3) | (sector >= 2 && sector < 5) << 1 | (sector >= 4 || sector == 0) << 2);
    if (f->step == COAST) {
        return in;
    }
    emf[A] = 0.25 * bus * trapezoid(f->x - 6.0 * (int)(f->x / 6.0));
    emf[B] = 0.25 * bus * trapezoid(f->x + 4.0 - 6.0 * (int)(f->x / 6.0));
    emf[C] = 0.25 * bus * trapezoid(f->x + 2.0 - 6.0 * (int)(f->x / 6.0));
    middle = 0.5 * (bus - emf[HIGH[f->step]] - emf[LOW[f->step]]);
    in.phase_voltage[HIGH[f->step]] = in.bus_voltage;
    in.phase_voltage[FLOATING[f->step]] = (uint16_t)(middle + emf[FLOATING[f->step]] + noise(f));
    if (f->x - f->commutated < 5.0 / 60.0) { /* after a high side a low diode conducts, and the other way round */
        in.phase_voltage[FLOATING[f->step]] = f->step & 1 ? in.bus_voltage : 0;
    }
    return in;
}

/* Counts of the system timer, which counts down; an instruction is 3.2 of them. */
#define TIMER_CONTROL (*(volatile uint32_t *)0xE000E010u)
#define TIMER_RELOAD (*(volatile uint32_t *)0xE000E014u)
#define TIMER_COUNT (*(volatile uint32_t *)0xE000E018u)

static uint32_t instructions(uint32_t start, uint32_t end)
{
    return (((start - end) & 0xFFFFFFu) * 10 + 16) / 32;
}

/* What a measurement costs itself. */
static uint32_t start_timer(void)
{
    uint32_t start, end;

    TIMER_RELOAD = 0xFFFFFFu;
    TIMER_COUNT = 0;
    TIMER_CONTROL = 5;
    start = TIMER_COUNT;
    end = TIMER_COUNT;
    return instructions(start, end);
}

/* A function of its own, so that what the compiler does around it does not move the figure. */
__attribute__((noipa)) static uint32_t measure(tick *step, struct drive *d, const struct samples *in, struct command *out)
{
    uint32_t start = TIMER_COUNT;

    step(d, in, out);
    return instructions(start, TIMER_COUNT);
}

static bool is_off(const struct command *out)
{
    return out->duty == 0 && out->step == COAST && out->next == COAST;
}

/* The limits that a run never meets: each switches this drive off, or takes its voltage away. */
static const char *limits(tick *step, const struct drive *from, const struct samples *in)
{
    struct samples wrong[3] = {*in, *in, *in}, loaded = *in, still = *in;
    struct drive d;
    struct command out;

    wrong[0].bus_current = 4000;
    wrong[1].bus_voltage = 3300;
    wrong[2].bus_voltage = 400;
    for (int i = 0; i < 3; i++) {
        d = *from;
        step(&d, &wrong[i], &out);
        step(&d, in, &out);
        if (!is_off(&out)) {
            return "a limit does not hold";
        }
    }
    d = *from;
    loaded.bus_current = 3000;
    for (int i = 0; i < 200; i++) {
        step(&d, &loaded, &out);
    }
    if (out.duty >= from->duty / 2) {
        return "the current is not limited";
    }
    d = *from;
    still.edge = false;
    for (int i = 0; i < 6000; i++) {
        /* Half way between the rails nothing crosses: always a little before. */
        for (int phase = A; phase <= C; phase++) {
            still.phase_voltage[phase] = (uint16_t)(still.bus_voltage / 2 + (d.step & 1 ? -9 : 9));
        }
        step(&d, &still, &out);
    }
    return is_off(&out) ? NULL : "a stall is not noticed";
}

/* A tick, and by how many of them it may commutate late, beside a degree of noise: by the hall code as sampled one. */
struct floor {
    const char *name;
    tick *step;
    double late;
};

/* Runs a tick and prints its row; a reason if it did not commutate as the rotor turned, or its duty does not live. */
static const char *run(const struct floor *floor, uint32_t millihertz, uint32_t ticks, uint32_t bracket)
{
    tick *step = floor->step;
    const char *name = floor->name;
    struct feed f = {.x = 0.01, .noise = 1};
    struct drive d = running(millihertz, 9000);
    struct samples in;
    struct command out;
    uint32_t total = 0, worst = 0, commutations = 0, loops = 0, lowest = 32768, highest = 0;
    bool in_order = true;
    double late, latest = 0.0;

    for (uint32_t i = 0; i < ticks; i++) {
        uint32_t spent;
        uint8_t last = f.step;

        in = turn(&f, millihertz / 1000.0);
        spent = measure(step, &d, &in, &out) - bracket;
        total += spent;
        worst = spent > worst ? spent : worst;
        lowest = out.duty < lowest ? out.duty : lowest;
        highest = out.duty > highest ? out.duty : highest;
        loops += d.millisecond == 0;
        f.step = out.next;
        if (f.step != last && i > 0) {
            f.commutated = f.x + (out.at / 65536.0) * (f.x - f.before);
            in_order &= f.step == ++commutations % 6;
            late = f.commutated - commutations;
            latest = late > latest ? late : -late > latest ? -late : latest;
        }
    }
    printf("floor %s %lu %lu %lu\n", name, (unsigned long)ticks, (unsigned long)total, (unsigned long)worst);
    printf("# %s: %lu commutations, at most %.1f degrees off; duty %.1f to %.1f %%\n", name, (unsigned long)commutations, 60.0 * latest,
           lowest / 327.68, highest / 327.68);
    if (commutations + 1 < (uint32_t)f.x || commutations > (uint32_t)f.x + 1) {
        return "the commutations are not those of the speed";
    }
    if (!in_order || latest > 1.0 / 60.0 + floor->late * 6e-4 * millihertz / 1000.0) {
        return "a commutation is off its place";
    }
    if (loops != ticks / 10 || highest < lowest + 1000 || lowest < 9830 || highest > 22938) {
        return "the duty does not follow bus and speed";
    }
    return limits(step, &d, &in);
}

int main(int count, char **arguments)
{
    static const struct floor floors[] = {{"hall", hall, 1.0}, {"sensorless", sensorless, 0.0}};
    uint32_t millihertz = count > 2 ? (uint32_t)atol(arguments[1]) : 0, ticks = count > 2 ? (uint32_t)atol(arguments[2]) : 0;
    uint32_t bracket = start_timer();

    if (millihertz < 20000 || millihertz > 400000 || ticks < 2000) {
        puts("usage: tick MILLIHERTZ (20 000 to 400 000) TICKS (from 2000)");
        return 2;
    }
    for (int i = 0; i < 2; i++) {
        const char *why = run(&floors[i], millihertz, ticks, bracket);

        if (why != NULL) {
            printf("error %s %s\n", floors[i].name, why);
            return 1;
        }
    }
    return 0;
}
