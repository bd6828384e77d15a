/* Tables of the NarMotion-X drive for a port by hand, made from narx's own. No other header of narx is needed. */

#ifndef NARX_PORT_TABLES_H
#define NARX_PORT_TABLES_H

#include <stdint.h>

#define NARX_PORT_INVALID 255

/* Sector by hall code (bit 0 = A) and order of the lines (parameter 262); invert the lines (parameter 263) before. Sector s
 * spans 30 + 60 s to 90 + 60 s electrical degrees. */
static const uint_least8_t narx_port_sectors[6][8] = {
    {255, 0, 2, 1, 4, 5, 3, 255},
    {255, 0, 4, 5, 2, 1, 3, 255},
    {255, 2, 0, 1, 4, 3, 5, 255},
    {255, 4, 0, 5, 2, 3, 1, 255},
    {255, 2, 4, 3, 0, 1, 5, 255},
    {255, 4, 2, 3, 0, 5, 1, 255},
};

/* Legs A, B, C by torque (0 forward, 1 reverse) and sector: 1 is switched with the duty, -1 has its low side on, 0 is off. */
static const int_least8_t narx_port_legs[2][6][3] = {
    {{1, -1, 0}, {1, 0, -1}, {0, 1, -1}, {-1, 1, 0}, {-1, 0, 1}, {0, -1, 1}},
    {{-1, 1, 0}, {-1, 0, 1}, {0, -1, 1}, {1, -1, 0}, {1, 0, -1}, {0, 1, -1}},
};

/* States (section 7). */
enum narx_port_state {
    NARX_PORT_STATE_INITIALIZATION = 0,
    NARX_PORT_STATE_STANDBY = 1,
    NARX_PORT_STATE_ROTOR_LOCK = 2,
    NARX_PORT_STATE_OPEN_LOOP = 3,
    NARX_PORT_STATE_SENSORLESS_CLOSED_LOOP = 4,
    NARX_PORT_STATE_HALL_CLOSED_LOOP = 5,
    NARX_PORT_STATE_FAULT = 6,
    NARX_PORT_STATE_SENSORLESS_AUTO_RESTART = 7
};

/* Conditions of the transitions, as bits: core/src/motor/machine/state.rs says when each holds. */
#define NARX_PORT_IF_BOOTED UINT16_C(0x0001)
#define NARX_PORT_IF_CRITICAL UINT16_C(0x0002)
#define NARX_PORT_IF_UNHEALTHY UINT16_C(0x0004)
#define NARX_PORT_IF_STANDBY UINT16_C(0x0008)
#define NARX_PORT_IF_START UINT16_C(0x0010)
#define NARX_PORT_IF_HALL UINT16_C(0x0020)
#define NARX_PORT_IF_SENSORLESS UINT16_C(0x0040)
#define NARX_PORT_IF_OPEN_LOOP UINT16_C(0x0080)
#define NARX_PORT_IF_CALIBRATION UINT16_C(0x0100)
#define NARX_PORT_IF_CALIBRATED UINT16_C(0x0200)
#define NARX_PORT_IF_EXPIRED UINT16_C(0x0400)
#define NARX_PORT_IF_ELAPSED UINT16_C(0x0800)
#define NARX_PORT_IF_STOPPED UINT16_C(0x1000)
#define NARX_PORT_IF_REVERSAL UINT16_C(0x2000)
#define NARX_PORT_IF_ACKNOWLEDGED UINT16_C(0x4000)
#define NARX_PORT_IF_OTHER_SOURCE UINT16_C(0x8000)

/* Table 7: from this state to that one when all of `all` and none of `none` hold. The first row that holds wins. */
struct narx_port_transition {
    uint_least8_t from;
    uint_least8_t to;
    uint_least16_t all;
    uint_least16_t none;
};
static const struct narx_port_transition narx_port_transitions[36] = {
    {0, 6, 0x0004u, 0x0000u},
    {0, 1, 0x0001u, 0x0000u},
    {1, 6, 0x0002u, 0x0000u},
    {1, 2, 0x0110u, 0x0408u},
    {1, 5, 0x0030u, 0x0408u},
    {1, 2, 0x0050u, 0x0428u},
    {1, 3, 0x0090u, 0x0468u},
    {2, 6, 0x0002u, 0x0000u},
    {2, 1, 0x0008u, 0x0000u},
    {2, 6, 0x0400u, 0x0000u},
    {2, 1, 0x2000u, 0x0000u},
    {2, 3, 0x0800u, 0x0000u},
    {3, 6, 0x0002u, 0x0000u},
    {3, 1, 0x0008u, 0x0000u},
    {3, 6, 0x0400u, 0x0000u},
    {3, 1, 0x0300u, 0x0000u},
    {3, 1, 0x3000u, 0x0000u},
    {3, 4, 0x0840u, 0x2120u},
    {4, 6, 0x0002u, 0x0000u},
    {4, 1, 0x0008u, 0x0000u},
    {4, 6, 0x0400u, 0x0000u},
    {4, 1, 0x3000u, 0x0000u},
    {4, 5, 0x9000u, 0x2000u},
    {4, 7, 0x1000u, 0x2000u},
    {5, 6, 0x0002u, 0x0000u},
    {5, 1, 0x0008u, 0x0000u},
    {5, 6, 0x0400u, 0x0000u},
    {5, 1, 0x3000u, 0x0000u},
    {5, 4, 0x8000u, 0x2000u},
    {6, 1, 0x4000u, 0x0002u},
    {7, 6, 0x0002u, 0x0000u},
    {7, 1, 0x0008u, 0x0000u},
    {7, 6, 0x0400u, 0x0000u},
    {7, 1, 0x3000u, 0x0000u},
    {7, 1, 0x1800u, 0x0000u},
    {7, 4, 0x0800u, 0x1000u},
};

/* Table 9: extended code, whose high byte is the bit of the fault word, and qualification time, us. */
struct narx_port_fault {
    uint_least16_t code;
    uint_least32_t qualification;
};
static const struct narx_port_fault narx_port_faults[26] = {
    {0x0001u, UINT32_C(100000)}, /* temperature above the warning threshold */
    {0x0101u, UINT32_C(100000)}, /* temperature above the shutdown threshold */
    {0x0201u, UINT32_C(10000)}, /* bus voltage above its threshold; at once when 1 V above */
    {0x0301u, UINT32_C(1000)}, /* bus voltage below its threshold */
    {0x0401u, UINT32_C(300)}, /* mean DC-link current above its threshold */
    {0x0501u, UINT32_C(0)}, /* the gate driver reports a fault */
    {0x0502u, UINT32_C(0)}, /* a phase carries no current (three revolutions, or 100 ms at rest) */
    {0x0601u, UINT32_C(0)}, /* hall codes 000 or 111 (64 more than one a millisecond) */
    {0x0602u, UINT32_C(0)}, /* hall sectors skipped (5 more than one in 13 ms) */
    {0x0603u, UINT32_C(0)}, /* torque applied at speed 0 (parameter 113) for the stall time (parameter 265) */
    {0x0604u, UINT32_C(0)}, /* hall edges run against the torque: wiring, or a load that drives backwards */
    {0x0605u, UINT32_C(0)}, /* the motor goes on without its hall sensors (parameter 308); no fault bit */
    {0x0701u, UINT32_C(10000)}, /* pressure above its threshold */
    {0x1A01u, UINT32_C(0)}, /* parameter store has another layout */
    {0x1B01u, UINT32_C(0)}, /* hardware break input */
    {0x1B02u, UINT32_C(0)}, /* self-test failed */
    {0x1B03u, UINT32_C(10000)}, /* speed above 130 % of the mode's maximum set-point */
    {0x1B04u, UINT32_C(0)}, /* the sensorless motor stalls or does not start, five times (one is forgiven in 10 s) */
    {0x1B05u, UINT32_C(0)}, /* zero crossings jump by more than half an interval, five times (one is forgiven in 10 s) */
    {0x1B06u, UINT32_C(0)}, /* sensorless speed and applied voltage do not fit together for 150 ms, five times (one is forgiven in 10 s) */
    {0x1B07u, UINT32_C(0)}, /* the motor goes on with its hall sensors (parameter 308); no fault bit */
    {0x1C01u, UINT32_C(0)}, /* shutdown requested over CAN (motor mode 3) */
    {0x1C02u, UINT32_C(1000)}, /* the digital input configured for shutdown */
    {0x1D01u, UINT32_C(0)}, /* no valid command while driving for the time-out (parameter 114) */
    {0x1E01u, UINT32_C(0)}, /* parameter store absent */
    {0x1F01u, UINT32_C(0)}, /* parameter store of another firmware version */
};

/* Parameters as they are on the wire: a value in its unit is raw * 10^exponent. An unsigned one of 32 bits is the same bits. */
struct narx_port_parameter {
    uint_least16_t number;
    int_least8_t exponent;
    int_least32_t minimum;
    int_least32_t maximum;
    int_least32_t factory;
};
static const struct narx_port_parameter narx_port_parameters[175] = {
    {0, 0, INT32_C(0), INT32_C(1), INT32_C(1)}, /* Memory Mapping Flag, - */
    {1, 0, INT32_C(0), INT32_C(65535), INT32_C(1)}, /* Device Number, - */
    {2, 0, INT32_C(0), INT32_C(255), INT32_C(170)}, /* Slave CAN address, - */
    {3, 0, INT32_C(0), INT32_C(255), INT32_C(85)}, /* Master CAN address, - */
    {4, 0, INT32_C(0), INT32_C(65535), INT32_C(0)}, /* Hardware Release, - */
    {5, 0, INT32_C(0), INT32_C(65535), INT32_C(0)}, /* Build number, - */
    {6, 0, INT32_C(0), INT32_C(65535), INT32_C(0)}, /* Software Release, - */
    {7, 0, INT32_C(0), INT32_C(1), INT32_C(0)}, /* Source modified, - */
    {8, 0, INT32_C(0), INT32_C(1), INT32_C(0)}, /* Temperature measurement source selection, - */
    {9, 0, INT32_C(0), INT32_C(1), INT32_C(1)}, /* Accel use ref for scaling selection, - */
    {10, -3, INT32_C(-2000), INT32_C(2000), INT32_C(0)}, /* Accel X calib offset, g */
    {11, -3, INT32_C(-2000), INT32_C(2000), INT32_C(0)}, /* Accel Y calib offset, g */
    {12, -3, INT32_C(-2000), INT32_C(2000), INT32_C(0)}, /* Accel Z calib offset, g */
    {13, -3, INT32_C(-2000), INT32_C(2000), INT32_C(0)}, /* HV current calib offset, A */
    {14, -3, INT32_C(-5000), INT32_C(5000), INT32_C(0)}, /* HV voltage calib offset, V */
    {15, -1, INT32_C(-500), INT32_C(500), INT32_C(0)}, /* Temperature calib offset, °C */
    {16, -2, INT32_C(-2147483647), INT32_C(2147483647), INT32_C(0)}, /* Mechanical position calibration value, deg */
    {17, 0, INT32_C(0), INT32_C(1), INT32_C(0)}, /* Set position calibration value (rising edge), - */
    {18, -3, INT32_C(-10000), INT32_C(10000), INT32_C(0)}, /* Pressure calib offset, V */
    {19, -6, INT32_C(-100000000), INT32_C(100000000), INT32_C(1000000)}, /* Pressure calib gain, - */
    {20, -3, INT32_C(-10000), INT32_C(10000), INT32_C(0)}, /* Pressure meas offset, V */
    {21, -6, INT32_C(-100000000), INT32_C(100000000), INT32_C(1000000)}, /* Pressure meas gain, - */
    {22, 0, INT32_C(1), INT32_C(8388607), INT32_C(7)}, /* Virtual Scop Channels Selection, - */
    {23, 0, INT32_C(1), INT32_C(4096), INT32_C(256)}, /* Virtual Scop Samples Number, samples */
    {24, 0, INT32_C(1), INT32_C(10000), INT32_C(1)}, /* Virtual Scop Sampling Prescaler, - */
    {25, -6, INT32_C(0), INT32_C(-1), INT32_C(100)}, /* Virtual Scop Sampling Time, s */
    {26, 0, INT32_C(0), INT32_C(4096), INT32_C(0)}, /* Virtual Scop Trig phase, samples */
    {27, 0, INT32_C(0), INT32_C(65535), INT32_C(43605)}, /* 01 - Logging start index, - */
    {28, 0, INT32_C(0), INT32_C(-1), INT32_C(0)}, /* 02 - Logging package index, - */
    {29, 0, INT32_C(0), INT32_C(262143), INT32_C(65535)}, /* 03 - Logging slot, - */
    {30, 0, INT32_C(0), INT32_C(262143), INT32_C(65535)}, /* 04 - Logging slot, - */
    {31, 0, INT32_C(0), INT32_C(262143), INT32_C(65535)}, /* 05 - Logging slot, - */
    {32, 0, INT32_C(0), INT32_C(262143), INT32_C(65535)}, /* 06 - Logging slot, - */
    {33, 0, INT32_C(0), INT32_C(262143), INT32_C(65535)}, /* 07 - Logging slot, - */
    {34, 0, INT32_C(0), INT32_C(262143), INT32_C(65535)}, /* 08 - Logging slot, - */
    {35, 0, INT32_C(0), INT32_C(262143), INT32_C(65535)}, /* 09 - Logging slot, - */
    {36, 0, INT32_C(0), INT32_C(262143), INT32_C(65535)}, /* 10 - Logging slot, - */
    {37, 0, INT32_C(0), INT32_C(262143), INT32_C(65535)}, /* 11 - Logging slot, - */
    {38, 0, INT32_C(0), INT32_C(262143), INT32_C(65535)}, /* 12 - Logging slot, - */
    {39, 0, INT32_C(0), INT32_C(262143), INT32_C(65535)}, /* 13 - Logging slot, - */
    {40, 0, INT32_C(0), INT32_C(262143), INT32_C(65535)}, /* 14 - Logging slot, - */
    {41, 0, INT32_C(0), INT32_C(262143), INT32_C(65535)}, /* 15 - Logging slot, - */
    {42, 0, INT32_C(0), INT32_C(262143), INT32_C(65535)}, /* 16 - Logging slot, - */
    {43, 0, INT32_C(0), INT32_C(262143), INT32_C(65535)}, /* 17 - Logging slot, - */
    {44, 0, INT32_C(0), INT32_C(262143), INT32_C(65535)}, /* 18 - Logging slot, - */
    {45, 0, INT32_C(0), INT32_C(262143), INT32_C(65535)}, /* 19 - Logging slot, - */
    {46, 0, INT32_C(0), INT32_C(262143), INT32_C(65535)}, /* 20 - Logging slot, - */
    {47, 0, INT32_C(0), INT32_C(262143), INT32_C(65535)}, /* 21 - Logging slot, - */
    {48, 0, INT32_C(0), INT32_C(262143), INT32_C(65535)}, /* 22 - Logging slot, - */
    {49, 0, INT32_C(0), INT32_C(262143), INT32_C(65535)}, /* 23 - Logging slot, - */
    {50, 0, INT32_C(0), INT32_C(262143), INT32_C(65535)}, /* 24 - Logging slot, - */
    {51, 0, INT32_C(0), INT32_C(262143), INT32_C(65535)}, /* 25 - Logging slot, - */
    {52, 0, INT32_C(0), INT32_C(262143), INT32_C(65535)}, /* 26 - Logging slot, - */
    {53, 0, INT32_C(0), INT32_C(262143), INT32_C(65535)}, /* 27 - Logging slot, - */
    {54, 0, INT32_C(0), INT32_C(262143), INT32_C(65535)}, /* 28 - Logging slot, - */
    {55, 0, INT32_C(0), INT32_C(262143), INT32_C(65535)}, /* 29 - Logging slot, - */
    {56, 0, INT32_C(0), INT32_C(262143), INT32_C(65535)}, /* 30 - Logging slot, - */
    {57, 0, INT32_C(0), INT32_C(262143), INT32_C(65535)}, /* 31 - Logging slot, - */
    {58, 0, INT32_C(0), INT32_C(262143), INT32_C(65535)}, /* 32 - Logging slot, - */
    {59, 0, INT32_C(0), INT32_C(262143), INT32_C(65535)}, /* 33 - Logging slot, - */
    {60, 0, INT32_C(0), INT32_C(262143), INT32_C(65535)}, /* 34 - Logging slot, - */
    {61, 0, INT32_C(0), INT32_C(262143), INT32_C(65535)}, /* 35 - Logging slot, - */
    {62, 0, INT32_C(0), INT32_C(262143), INT32_C(65535)}, /* 36 - Logging slot, - */
    {63, 0, INT32_C(0), INT32_C(262143), INT32_C(65535)}, /* 37 - Logging slot, - */
    {64, 0, INT32_C(0), INT32_C(262143), INT32_C(65535)}, /* 38 - Logging slot, - */
    {65, 0, INT32_C(0), INT32_C(262143), INT32_C(65535)}, /* 39 - Logging slot, - */
    {66, 0, INT32_C(0), INT32_C(65535), INT32_C(21930)}, /* 40 - Logging end index, - */
    {67, 0, INT32_C(0), INT32_C(2147483647), INT32_C(0)}, /* Logging read start index, - */
    {68, 0, INT32_C(0), INT32_C(2147483647), INT32_C(1)}, /* Logging read number of indexes, - */
    {69, 0, INT32_C(0), INT32_C(65535), INT32_C(0)}, /* Logging data size bytes, bytes */
    {70, 0, INT32_C(0), INT32_C(2147483647), INT32_C(0)}, /* Logging data max index, - */
    {71, 0, INT32_C(0), INT32_C(2147483647), INT32_C(0)}, /* Logging data write index, - */
    {72, 0, INT32_C(1), INT32_C(3600000), INT32_C(1000)}, /* Logging period, ms */
    {73, 0, INT32_C(0), INT32_C(2147483647), INT32_C(0)}, /* Logging data subsectors number, - */
    {74, 0, INT32_C(0), INT32_C(2147483647), INT32_C(0)}, /* Logging data ongoing subsector erase index, - */
    {75, 0, INT32_C(0), INT32_C(1), INT32_C(0)}, /* Logging read request, - */
    {76, 0, INT32_C(0), INT32_C(1), INT32_C(0)}, /* Logging erase request, - */
    {77, 0, INT32_C(0), INT32_C(1), INT32_C(0)}, /* Logging memory full flag, - */
    {78, 0, INT32_C(1), INT32_C(50), INT32_C(4)}, /* Motor pair poles, - */
    {79, 0, INT32_C(0), INT32_C(1), INT32_C(1)}, /* Select control sequence for standard motor, - */
    {80, -2, INT32_C(-18000), INT32_C(18000), INT32_C(0)}, /* Hall effect offset angle, deg */
    {81, 0, INT32_C(0), INT32_C(1), INT32_C(0)}, /* Open-loop enable, - */
    {82, 0, INT32_C(0), INT32_C(1), INT32_C(0)}, /* Closed-loop Sensorless enable, - */
    {83, 0, INT32_C(0), INT32_C(1), INT32_C(0)}, /* Closed-loop Hall Effect Sensors enable, - */
    {84, -2, INT32_C(0), INT32_C(10000), INT32_C(0)}, /* Closed-Loop initial duty cycle, % */
    {85, 0, INT32_C(10), INT32_C(32767), INT32_C(500)}, /* Max period between two ZC events, ticks */
    {86, 0, INT32_C(0), INT32_C(100), INT32_C(2)}, /* N periods to discard after a sector change, ticks */
    {87, -2, INT32_C(0), INT32_C(10000), INT32_C(400)}, /* Open-Loop duty cycle, % */
    {88, 0, INT32_C(0), INT32_C(65535), INT32_C(500)}, /* Open-loop speed setpoint, rpm */
    {89, -2, INT32_C(0), INT32_C(10000), INT32_C(400)}, /* Rotor lock duty cycle, % */
    {90, -6, INT32_C(0), INT32_C(2147483647), INT32_C(1800000)}, /* Speed Ki coefficient SL, V/rad */
    {91, -6, INT32_C(0), INT32_C(2147483647), INT32_C(2400)}, /* Speed Kp coefficient SL, V.s/rad */
    {92, -9, INT32_C(0), INT32_C(2147483647), INT32_C(188000000)}, /* Speed Ki coefficient HES, V/(rpm.s) */
    {93, -9, INT32_C(0), INT32_C(2147483647), INT32_C(250000)}, /* Speed Kp coefficient HES, V/rpm */
    {94, -6, INT32_C(0), INT32_C(2147483647), INT32_C(100000)}, /* HV current Kp coefficient, V/A */
    {95, -3, INT32_C(0), INT32_C(2147483647), INT32_C(180000)}, /* HV current Ki coefficient, V/(A.s) */
    {96, -3, INT32_C(100), INT32_C(10000000), INT32_C(60000)}, /* Max HV current setpoint rate, A/s */
    {97, 0, INT32_C(0), INT32_C(1), INT32_C(1)}, /* Hall Effect Sensors PS enable, - */
    {98, -2, INT32_C(0), INT32_C(10000), INT32_C(9500)}, /* Max duty cycle SL, % */
    {99, 0, INT32_C(1), INT32_C(10000000), INT32_C(2000)}, /* Speed setpoint rate, rpm/s */
    {100, -2, INT32_C(0), INT32_C(10000), INT32_C(0)}, /* ZC delay compensation, ticks */
    {101, 0, INT32_C(0), INT32_C(65535), INT32_C(4000)}, /* Speed setpoint max saturation SL, rpm */
    {102, 0, INT32_C(0), INT32_C(65535), INT32_C(500)}, /* Speed setpoint min saturation SL, rpm */
    {103, 0, INT32_C(0), INT32_C(65535), INT32_C(4000)}, /* Speed setpoint max saturation HES, rpm */
    {104, 0, INT32_C(0), INT32_C(65535), INT32_C(500)}, /* Speed setpoint min saturation HES, rpm */
    {105, -3, INT32_C(0), INT32_C(7000), INT32_C(3000)}, /* Max HV current limitation soft start, A */
    {106, -3, INT32_C(0), INT32_C(7000), INT32_C(6000)}, /* Max HV current limitation, A */
    {107, -2, INT32_C(0), INT32_C(10000), INT32_C(9500)}, /* Max duty cycle, % */
    {108, -3, INT32_C(0), INT32_C(60000), INT32_C(500)}, /* Open-Loop phase duration, s */
    {109, -3, INT32_C(0), INT32_C(60000), INT32_C(400)}, /* Open-Loop ramp rising time, s */
    {110, -3, INT32_C(0), INT32_C(60000), INT32_C(150)}, /* Rotor lock phase duration, s */
    {111, 0, INT32_C(1), INT32_C(60000), INT32_C(50)}, /* can_autosend_period, ms */
    {112, 0, INT32_C(0), INT32_C(60000), INT32_C(500)}, /* Fault state wait time before acknowledgement, ms */
    {113, -3, INT32_C(1), INT32_C(6000), INT32_C(100)}, /* Electrical period measurement time-out, s */
    {114, 0, INT32_C(1), INT32_C(60000), INT32_C(250)}, /* Can TimeOut period, ms */
    {115, 0, INT32_C(0), INT32_C(-1), INT32_C(-67108738)}, /* Critical fault mask, - */
    {116, -3, INT32_C(100), INT32_C(7000), INT32_C(7000)}, /* Over-current HV threshold, A */
    {117, -3, INT32_C(-10000), INT32_C(10000), INT32_C(3300)}, /* Over-pressure threshold, V */
    {118, -1, INT32_C(0), INT32_C(2000), INT32_C(1900)}, /* Over-temperature shutdown threshold, °C */
    {119, -3, INT32_C(18000), INT32_C(62000), INT32_C(61000)}, /* Over-voltage HV threshold, V */
    {120, -3, INT32_C(8000), INT32_C(60000), INT32_C(16000)}, /* Under-voltage HV threshold, V */
    {121, -1, INT32_C(0), INT32_C(2000), INT32_C(1850)}, /* Over-temperature warning threshold, °C */
    {256, 0, INT32_C(0), INT32_C(1), INT32_C(0)}, /* Store parameters, - */
    {257, 0, INT32_C(0), INT32_C(1), INT32_C(0)}, /* Store once parameters, - */
    {258, 0, INT32_C(0), INT32_C(1), INT32_C(0)}, /* Reset calibration parameters, - */
    {259, 0, INT32_C(0), INT32_C(1), INT32_C(0)}, /* Auto-calibrate, - */
    {260, 0, INT32_C(0), INT32_C(3), INT32_C(0)}, /* Scope state, - */
    {261, 0, INT32_C(0), INT32_C(7), INT32_C(0)}, /* Drive state, - */
    {262, 0, INT32_C(0), INT32_C(5), INT32_C(0)}, /* Hall order, - */
    {263, 0, INT32_C(0), INT32_C(7), INT32_C(0)}, /* Hall polarity mask, - */
    {264, 0, INT32_C(0), INT32_C(1), INT32_C(0)}, /* Hall calibration request, - */
    {265, 0, INT32_C(10), INT32_C(10000), INT32_C(500)}, /* Hall stall time, ms */
    {266, -3, INT32_C(0), INT32_C(60000), INT32_C(0)}, /* Nominal supply voltage, V */
    {267, -6, INT32_C(0), INT32_C(1000000), INT32_C(0)}, /* Back-EMF constant, V/rpm */
    {268, -3, INT32_C(0), INT32_C(100000), INT32_C(0)}, /* Winding resistance, ohm */
    {269, -3, INT32_C(100), INT32_C(12000), INT32_C(12000)}, /* Phase current limit, A */
    {270, 0, INT32_C(0), INT32_C(2), INT32_C(0)}, /* Digital shutdown input, - */
    {271, -2, INT32_C(1), INT32_C(10000), INT32_C(1000)}, /* Duty slew limit, %/ms */
    {272, 0, INT32_C(0), INT32_C(20000), INT32_C(2000)}, /* Minimum on-time, ns */
    {273, -2, INT32_C(0), INT32_C(3000), INT32_C(0)}, /* Timing advance, deg */
    {274, 0, INT32_C(0), INT32_C(-1), INT32_C(0)}, /* Refused frames, - */
    {275, 0, INT32_C(0), INT32_C(-1), INT32_C(0)}, /* Malformed frames, - */
    {276, 0, INT32_C(0), INT32_C(65535), INT32_C(0)}, /* Start refusal, - */
    {277, 0, INT32_C(0), INT32_C(65535), INT32_C(0)}, /* Hall invalid codes, - */
    {278, 0, INT32_C(0), INT32_C(65535), INT32_C(0)}, /* Hall jumps, - */
    {279, 0, INT32_C(0), INT32_C(3), INT32_C(0)}, /* Hall calibration state, - */
    {280, 0, INT32_C(0), INT32_C(65535), INT32_C(0)}, /* Active limiter, - */
    {281, 0, INT32_C(0), INT32_C(65535), INT32_C(100)}, /* Hall interpolation speed, rpm */
    {282, 0, INT32_C(0), INT32_C(65535), INT32_C(0)}, /* Extended fault code, - */
    {283, -6, INT32_C(0), INT32_C(100000), INT32_C(0)}, /* Winding inductance, H */
    {284, 0, INT32_C(0), INT32_C(-1), INT32_C(0)}, /* Frames lost, - */
    {285, 0, INT32_C(0), INT32_C(65535), INT32_C(65535)}, /* Rejected parameter, - */
    {286, -2, INT32_C(-10000), INT32_C(10000), INT32_C(0)}, /* ZC falling delay difference, ticks */
    {287, 0, INT32_C(0), INT32_C(65535), INT32_C(0)}, /* Last zero crossing, - */
    {288, -2, INT32_C(-18000), INT32_C(18000), INT32_C(0)}, /* Zero crossing margin, deg */
    {289, 0, INT32_C(0), INT32_C(-1), INT32_C(0)}, /* Zero crossings, - */
    {290, 0, INT32_C(0), INT32_C(6), INT32_C(0)}, /* Scope trigger, - */
    {291, 0, INT32_C(0), INT32_C(22), INT32_C(3)}, /* Scope trigger signal, - */
    {292, -3, INT32_C(-8000), INT32_C(7999), INT32_C(0)}, /* Scope trigger level, - */
    {293, 0, INT32_C(0), INT32_C(2), INT32_C(0)}, /* Bus error state, - */
    {294, 0, INT32_C(0), INT32_C(65535), INT32_C(0)}, /* Transmit error counter, - */
    {295, 0, INT32_C(0), INT32_C(65535), INT32_C(0)}, /* Receive error counter, - */
    {296, 0, INT32_C(0), INT32_C(-1), INT32_C(0)}, /* Bus-offs, - */
    {297, -3, INT32_C(0), INT32_C(3300), INT32_C(1800)}, /* Accel meas offset, V */
    {298, -2, INT32_C(0), INT32_C(18000), INT32_C(0)}, /* Tilt, deg */
    {299, -3, INT32_C(0), INT32_C(65535), INT32_C(0)}, /* Vibration, g */
    {300, 0, INT32_C(0), INT32_C(1), INT32_C(0)}, /* Scope inputs, - */
    {301, 0, INT32_C(0), INT32_C(65535), INT32_C(0)}, /* Scope words, - */
    {302, 0, INT32_C(0), INT32_C(6), INT32_C(0)}, /* Reset cause, - */
    {303, 0, INT32_C(0), INT32_C(31), INT32_C(0)}, /* Failed self-tests, - */
    {304, 0, INT32_C(0), INT32_C(7), INT32_C(0)}, /* Diagnostics, - */
    {305, 0, INT32_C(0), INT32_C(65535), INT32_C(0)}, /* Scope room, - */
    {306, 0, INT32_C(0), INT32_C(7), INT32_C(0)}, /* Scope refusal, - */
    {307, 0, INT32_C(0), INT32_C(1), INT32_C(1)}, /* Automatic store, - */
    {308, 0, INT32_C(0), INT32_C(1), INT32_C(0)}, /* Other rotor source, - */
};

#endif
