"""Speed of the simulation of one motor from Python: `speed.py CONTENDER` prints simulated seconds per second,
then the contender and its result.

All contenders turn the same motor (BLY172S, 24 V) at about 3000 rpm under rated load, on one thread. Start
and compilation come first and are not measured.
"""

from __future__ import annotations

import contextlib
import math
import sys
import time
import warnings
from collections.abc import Callable
from typing import Any

PRESET, SUPPLY, RPM = "bly172s-24v", 24.0, 3000.0
SPEED = RPM * 2.0 * math.pi / 60.0
# Motor data in the form of lab/floor/plant.c: per phase ohm and henry, V s/rad of one phase, kg m2, N m,
# N m s2/rad2.
POLE_PAIRS, R, L, K, J, FRICTION, LOAD = 4, 0.404, 0.64e-3, 0.017215, 4.8e-6, 0.00964, 1.12e-6


def measured(run: Callable[[float], object], seconds: float) -> float:
    """Returns simulated seconds per second of `run(seconds)`."""
    begun = time.perf_counter()
    run(seconds)
    return seconds / (time.perf_counter() - begun)


EIGHT = ["speed", "torque", "current_a", "current_b", "current_c", "bus_voltage", "bus_current", "duty"]


def narx_bench(mode: str, recording: bool = False, **kept: Any) -> tuple[float, str]:
    """Measures `Bench.run` with what it keeps: nothing, like the Rust bench sim/examples/driven.rs, or signals
    of each tick, or these and the recording.

    A day's work is many runs, one after another; so these are ten. The first one takes its memory page by page
    from the operating system: its rate is told beside that of all.
    """
    import narx

    bench = narx.Bench(narx.Motor.preset(PRESET), SUPPLY, narx.Load(quadratic=LOAD), mode=mode, recording=recording)  # type: ignore[arg-type]
    bench.drive.start(RPM)
    bench.run(2.0)
    rates = [measured(lambda seconds: bench.run(seconds, **kept), 4.0) for _ in range(10)]
    rate = len(rates) / sum(1.0 / rate for rate in rates)
    return rate, f"narx.Bench.run, the first one {rates[0]:.0f}, {bench.run(0.1)['speed'].mean():.0f} rpm"


def numba_loop() -> tuple[float, str]:
    """Measures the loop of lab/floor/plant.c in numba: a six-step drive with ideal hall sensors, 10 Euler
    steps a PWM period."""
    import numpy as np
    from numba import njit

    @njit(fastmath=False)  # type: ignore[untyped-decorator]
    def run(seconds: float) -> float:
        substeps, tick = 10, 1e-4
        sixth = 3.0 / math.pi
        high, low = (0, 0, 1, 1, 2, 2), (1, 2, 2, 0, 0, 1)
        offset = (0.0, 4.0, 2.0)
        i, shape, drive = np.zeros(3), np.zeros(3), np.zeros(3)
        omega, x, travelled = 0.0, 0.1, 0.0
        duty, integral, limit = 0.1, 2.0, SUPPLY
        h = tick / substeps
        ticks = int(seconds / tick)
        for number in range(ticks):
            sector = int(x)
            a, b = high[sector], low[sector]
            c = 3 - a - b
            limit = min(max(limit + 0.02 * (8.0 - max(i[a], -i[b])), 0.0), SUPPLY)
            if number % 10 == 0:
                error = SPEED - omega
                integral = min(max(integral + 0.002 * error, 0.0), SUPPLY)
                duty = min(max(min(integral + 0.05 * error, limit) / SUPPLY, 0.0), 0.95)
            for k in range(substeps):
                on = min(max(duty * substeps - k, 0.0), 1.0)
                for leg in range(3):
                    y = x + offset[leg]
                    y = y - 6.0 if y >= 6.0 else y
                    shape[leg] = min(max(5.0 - 2.0 * y if y < 4.0 else 2.0 * y - 11.0, -1.0), 1.0)
                back = K * omega
                drive[a] = SUPPLY * on - back * shape[a]
                drive[b] = -back * shape[b]
                if i[c] != 0.0:
                    before = i[c]
                    drive[c] = (SUPPLY if before < 0.0 else 0.0) - back * shape[c]
                    neutral = (drive[0] + drive[1] + drive[2]) / 3.0
                    for leg in range(3):
                        i[leg] += (drive[leg] - neutral - R * i[leg]) * h / L
                    if i[c] * before <= 0.0:
                        left = 0.5 * (i[a] - i[b])
                        i[a], i[b], i[c] = left, -left, 0.0
                else:
                    change = (0.5 * (drive[a] - drive[b]) - R * i[a]) * h / L
                    i[a] += change
                    i[b] -= change
                torque = K * (shape[0] * i[0] + shape[1] * i[1] + shape[2] * i[2])
                omega += (torque - LOAD * omega * omega - (FRICTION if omega > 0.0 else 0.0)) * h / J
                x += omega * POLE_PAIRS * sixth * h
                x = x - 6.0 if x >= 6.0 else x + 6.0 if x < 0.0 else x
            if number >= ticks // 2:
                travelled += omega
        return float(travelled / (ticks - ticks // 2) * 30.0 / math.pi)

    rpm = run(1.0)
    rate = measured(run, 10.0)
    return (
        rate,
        f"numba: six-step with ideal hall sensors, stiff supply, no dead time, no CAN; Euler, 10 us; keeps nothing, {rpm:.0f} rpm",
    )


def motulator_drive() -> tuple[float, str]:
    """Measures motulator: the same motor with a sinusoidal back-EMF, vector control at 10 kHz, ideal averaged
    inverter."""
    import numpy as np
    from motulator.drive import model
    from motulator.drive.control import sm as control
    from motulator.drive.utils import SynchronousMachinePars

    pars = SynchronousMachinePars(n_p=POLE_PAIRS, R_s=R, L_d=L, L_q=L, psi_f=K / POLE_PAIRS)
    mechanics = model.StiffMechanicalSystem(J=J, tau_L=lambda t: FRICTION + LOAD * SPEED**2)
    drive = model.Drive(model.VoltageSourceConverter(u_dc=SUPPLY), model.SynchronousMachine(pars), mechanics)
    current = control.CurrentReferenceCfg(pars, nom_w_m=POLE_PAIRS * SPEED, max_i_s=12.0)
    vector = control.CurrentVectorControl(pars, current, T_s=1e-4, J=J, sensorless=False)
    vector.ref.w_m = lambda t: POLE_PAIRS * SPEED * min(t / 0.3, 1.0)
    simulation = model.Simulation(drive, vector)
    rate = measured(lambda seconds: simulation.simulate(t_stop=seconds), 1.0)
    rpm = np.mean(drive.mechanics.data.w_M[-200:]) * 30.0 / math.pi
    return (
        rate,
        f"motulator: PMSM with vector control at 10 kHz, averaged inverter; scipy's RK45; keeps its states, {rpm:.0f} rpm",
    )


def gym_motor() -> tuple[float, str]:
    """Measures gym-electric-motor: the same motor with a sinusoidal back-EMF, fed with sinusoidal voltages by
    its angle, averaged inverter; no controller."""
    import gym_electric_motor as gem
    import numpy as np

    figures = {"p": POLE_PAIRS, "r_s": R, "l_d": L, "l_q": L, "psi_p": K / POLE_PAIRS, "j_rotor": J}
    limits = {"omega": 2.0 * SPEED, "i": 100.0, "u": 2.0 * SUPPLY, "torque": 10.0}
    load = gem.physical_systems.PolynomialStaticLoad(
        load_parameter={"a": FRICTION, "b": 0.0, "c": LOAD, "j_load": 1e-9}
    )
    environment: Any = gem.make(
        "Cont-SC-PMSM-v0",
        motor={"motor_parameter": figures, "limit_values": limits, "nominal_values": limits},
        supply={"u_nominal": SUPPLY}, load=load, constraints=(),
    ).unwrapped  # fmt: skip
    environment.reset(seed=1)
    system = environment.physical_system
    omega, epsilon = (system.state_names.index(name) for name in ("omega", "epsilon"))
    phases = np.arange(3) * math.tau / 3.0

    def run(seconds: float) -> float:
        speed = angle = 0.0
        for _ in range(round(seconds / system.tau)):
            (state, _), *_ = environment.step(AMPLITUDE * np.sin(phases - angle))
            speed = state[omega] * system.limits[omega]
            angle = state[epsilon] * system.limits[epsilon]
        return speed

    run(0.05)
    begun = time.perf_counter()
    speed = run(0.5)
    rate = 0.5 / (time.perf_counter() - begun)
    return rate, (
        "gym-electric-motor: PMSM fed with sines of fixed amplitude at 10 kHz, averaged inverter, no controller; scipy's dopri5; "
        f"keeps nothing, {speed * 30.0 / math.pi:.0f} rpm"
    )


AMPLITUDE = 1.0
"""Amplitude of the phase voltages, in halves of the supply: it gives nearly 3000 rpm under load."""
CONTENDERS: dict[str, Callable[[], tuple[float, str]]] = {
    "hall": lambda: narx_bench("hall", trace=False),
    "hall-eight": lambda: narx_bench("hall", signals=EIGHT),
    "hall-kept": lambda: narx_bench("hall", recording=True),
    "sensorless": lambda: narx_bench("sensorless", trace=False),
    "sensorless-eight": lambda: narx_bench("sensorless", signals=EIGHT),
    "sensorless-kept": lambda: narx_bench("sensorless", recording=True),
    "numba": numba_loop,
    "motulator": motulator_drive,
    "gym-electric-motor": gym_motor,
}

if __name__ == "__main__":
    # Warnings and output of the other libraries are not part of the result.
    warnings.simplefilter("ignore")
    with contextlib.redirect_stdout(sys.stderr):
        figure, what = CONTENDERS[sys.argv[1]]()
    print(f"{figure:.3g} {what}")
