/* The floor beside the bench: the simplest loop that still is a six-step drive, by hand.
 *
 * Ideal trapezoidal back-EMF, a stiff supply, ideal switches and diodes, no dead time, no sensors, no energy accounts, no
 * CAN; explicit Euler steps of a tenth of the PWM period; a speed PI at 1 kHz and a current limit every tick, in floating
 * point. Usage: plant SECONDS. Prints simulated seconds a second, and the mean speed in rpm of the second half.
 */
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { SUBSTEPS = 10 };

/* BLY172S on 24 V: per phase ohm and henry, V s/rad of one phase, kg m2, N m, N m s2/rad2 (3000 rpm at rated torque). */
static const double R = 0.404, L = 0.64e-3, K = 0.017215, J = 4.8e-6, FRICTION = 0.00964, LOAD = 1.12e-6;
static const double BUS = 24.0, POLE_PAIRS = 4.0, TICK = 1e-4;
static const double SIXTH = 0.9549296585513720; /* sixths of a turn in a radian */

/* High and low leg of each sector. */
static const int HIGH[6] = {0, 0, 1, 1, 2, 2};
static const int LOW[6] = {1, 2, 2, 0, 0, 1};

/* A unit trapezoid; x in sixths of a turn, 0 where it begins to be flat. */
static inline double trapezoid(double x) {
    x = x >= 6.0 ? x - 6.0 : x;
    double y = x < 4.0 ? 5.0 - 2.0 * x : 2.0 * x - 11.0;
    y = y > 1.0 ? 1.0 : y;
    return y < -1.0 ? -1.0 : y;
}

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

int main(int count, char **arguments) {
    double seconds = count > 1 ? atof(arguments[1]) : 10.0;
    long ticks = (long)(seconds / TICK), half = ticks / 2;
    double i[3] = {0.0, 0.0, 0.0}, omega = 0.0, x = 0.1, travelled = 0.0;
    double duty = 0.1, integral = 2.0, limit = BUS, target = 3000.0 * 0.10471975511965977;
    const double h = TICK / SUBSTEPS, per_l = h / L, per_j = h / J;
    double begun = now();
    for (long tick = 0; tick < ticks; tick++) {
        int sector = (int)x, a = HIGH[sector], b = LOW[sector], c = 3 - a - b;
        double current = i[a] > -i[b] ? i[a] : -i[b];
        limit += 0.02 * (8.0 - current);
        limit = limit > BUS ? BUS : limit < 0.0 ? 0.0 : limit;
        if (tick % 10 == 0) {
            double error = target - omega;
            integral += 0.002 * error;
            integral = integral > BUS ? BUS : integral < 0.0 ? 0.0 : integral;
            double volts = integral + 0.05 * error;
            volts = volts < limit ? volts : limit;
            duty = volts / BUS;
            duty = duty > 0.95 ? 0.95 : duty < 0.0 ? 0.0 : duty;
        }
        for (int k = 0; k < SUBSTEPS; k++) {
            double on = duty * SUBSTEPS - k;
            on = on > 1.0 ? 1.0 : on < 0.0 ? 0.0 : on;
            double shape[3] = {trapezoid(x), trapezoid(x + 4.0), trapezoid(x + 2.0)};
            double back = K * omega, drive[3], neutral;
            drive[a] = BUS * on - back * shape[a];
            drive[b] = -back * shape[b];
            if (i[c] != 0.0) { /* demagnetisation through a diode */
                double before = i[c];
                drive[c] = (before < 0.0 ? BUS : 0.0) - back * shape[c];
                neutral = (drive[0] + drive[1] + drive[2]) * (1.0 / 3.0);
                for (int leg = 0; leg < 3; leg++) i[leg] += (drive[leg] - neutral - R * i[leg]) * per_l;
                if (i[c] * before <= 0.0) {
                    double left = 0.5 * (i[a] - i[b]);
                    i[a] = left, i[b] = -left, i[c] = 0.0;
                }
            } else {
                double change = (0.5 * (drive[a] - drive[b]) - R * i[a]) * per_l;
                i[a] += change;
                i[b] -= change;
            }
            double torque = K * (shape[0] * i[0] + shape[1] * i[1] + shape[2] * i[2]);
            omega += (torque - LOAD * omega * omega - (omega > 0.0 ? FRICTION : 0.0)) * per_j;
            x += omega * (POLE_PAIRS * SIXTH) * h;
            x = x >= 6.0 ? x - 6.0 : x < 0.0 ? x + 6.0 : x;
        }
        travelled += tick >= half ? omega : 0.0;
    }
    double elapsed = now() - begun;
    printf("%.1f %.1f\n", seconds / elapsed, travelled / (double)(ticks - half) * 9.549296585513720);
    return 0;
}
