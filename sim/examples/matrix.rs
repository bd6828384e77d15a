use narx_core::motor::*;
use narx_core::units::*;
use narx_sim::commissioning::*;
use narx_sim::plant::*;
fn main() {
    let m = |pp, r, l, k, j, i0: f64| MotorConfig {
        pole_pairs: pp,
        resistance: r,
        inductance: l,
        torque_constant: k,
        inertia: j,
        static_friction: k * i0 * 0.6,
        viscous_friction: 0.0,
        ..MotorConfig::default()
    };
    let motors = [
        ("ec45-18", m(8, 0.447, 0.000243, 0.0295, 1.35e-5, 0.277), 18.0, 0.112, 3.68),
        ("ec45-36", m(8, 2.24, 0.000868, 0.0557, 1.35e-5, 0.151), 36.0, 0.0909, 1.63),
        ("ec45-70-60", m(8, 7.37, 0.00427, 0.152, 1.81e-5, 0.057), 60.0, 0.143, 0.92),
        ("ec4pole", m(2, 0.21, 3.7e-5, 0.0206, 3.33e-6, 0.482), 36.0, 0.0952, 5.06),
        ("ecmax40", m(1, 1.03, 0.000204, 0.0448, 1.01e-5, 0.2), 48.0, 0.17, 4.06),
        ("ec90", m(12, 0.363, 0.000264, 0.0705, 0.000306, 0.539), 24.0, 0.387, 5.39),
        ("faulh", m(7, 0.46, 0.000396, 0.0298, 6.9e-6, 0.177), 18.0, 0.102, 3.33),
        ("qbl", m(2, 0.45, 0.0014, 0.063, 1.73e-5, 0.2), 36.0, 0.32, 5.08),
        (
            "bly172",
            MotorConfig { back_emf: BackEmf::Sinusoidal, ..m(4, 0.768, 0.00128, 0.03443, 4.8e-6, 0.2) },
            24.0,
            0.1,
            3.5,
        ),
        (
            "beck",
            MotorConfig { back_emf: BackEmf::Sinusoidal, ..m(3, 1.25, 0.0007, 0.06448, 7.5e-6, 0.2) },
            48.0,
            0.2,
            4.0,
        ),
    ];
    let frac: f64 = std::env::args().nth(1).map_or(0.5, |s| s.parse().unwrap());
    for (name, motor, vnom, trated, irated) in motors {
        for supply in [18.0, 24.0, 48.0, 60.0, vnom] {
            for load in [0.0, trated] {
                let plate = Nameplate { motor, rated_current: Some(irated), supply };
                let com = match plate.commission(Mode::Hall) {
                    Ok(c) => c,
                    Err(e) => {
                        println!("{name:10} {supply:4} V: {e}");
                        continue;
                    }
                };
                let c = match Coefficients::build(&com.parameters, &Board::BENCH) {
                    Ok(c) => c,
                    Err(e) => {
                        println!("{name} {supply}: {e}");
                        continue;
                    }
                };
                let mut drive = Drive::new(c);
                let mut cfg = PlantConfig::new(motor, supply);
                cfg.load.constant = load;
                cfg.angle_deg = 77.0;
                let mut plant = Plant::new(&cfg);
                let rpm = com.speed_min + frac * (com.speed_max - com.speed_min);
                let pp = f64::from(motor.pole_pairs);
                let (mut peak, mut vpk, mut rise, mut over, mut a0, mut n) =
                    (0.0f64, 0.0f64, -1.0, 0.0f64, 0.0, 0);
                let (mut lo, mut hi) = (1e9f64, -1e9f64);
                let mut state = State::Initialization;
                let mut code = 0;
                let mut lim = None;
                for k in 0..25_500u64 {
                    let s = plant.sample();
                    if k % 500 == 0 && k >= 5500 {
                        drive.handle_event(Event::Command(Command {
                            request: Request::Drive,
                            speed: ElectricalSpeed::from_bits((rpm / 60.0 * pp * 65536.0) as i32),
                        }));
                    }
                    let p = drive.step(&s);
                    if let Some(st) = drive.poll_status() {
                        state = st.state;
                        code = st.extended_code;
                        lim = Some(st.limiter);
                    }
                    plant.finish_period(&p);
                    let o = plant.observe();
                    let w = o.speed * 9.549297;
                    for i in o.current {
                        peak = peak.max(i.abs());
                    }
                    vpk = vpk.max(o.bus_voltage);
                    if rise < 0.0 && w > 0.9 * rpm {
                        rise = o.time - 0.55;
                    }
                    over = over.max(w / rpm - 1.0);
                    if k == 20_500 {
                        a0 = o.angle;
                    }
                    if k > 20_500 {
                        lo = lo.min(w);
                        hi = hi.max(w);
                    }
                    n = k;
                    if std::env::args().nth(2).is_some_and(|x| x == name)
                        && std::env::args().nth(3).is_some_and(|x| x.parse::<f64>().unwrap() == supply)
                        && std::env::args().nth(4).is_some_and(|x| (x == "l") == (load > 0.0))
                        && k >= 5500
                        && k % std::env::args().nth(5).map_or(200, |x| x.parse::<u64>().unwrap()) == 0
                    {
                        let st = drive.clone();
                        let _ = st;
                        println!(
                            "{:.4} w {w:7.1} duty {:.4} {:?} {:?} I {:6.2} {:6.2} {:6.2} V {:.2} Ib {:.3} lim {:?} T {:.3} L {:?} el {:.3}",
                            o.time,
                            f64::from(p.duty.to_bits()) / 32768.0,
                            p.step,
                            p.rectification,
                            o.current[0],
                            o.current[1],
                            o.current[2],
                            o.bus_voltage,
                            o.bus_current,
                            lim,
                            o.torque,
                            drive.limiter(),
                            o.electrical_turns.rem_euclid(1.0)
                        );
                    }
                }
                let o = plant.observe();
                let mean = (o.angle - a0) / (f64::from((n - 20_500) as u32) * 1e-4) * 9.549297;
                println!(
                    "{name:10} {supply:4} V load {load:.3} rpm {rpm:6.0}: {state:?} {code:x} rise {rise:.3} over {:5.1}% mean err {:6.2}% ripple {:5.1}% peak {peak:5.1} A Vmax {vpk:.2} lim {:?} {}",
                    over * 100.0,
                    (mean / rpm - 1.0) * 100.0,
                    (hi - lo) / rpm * 100.0,
                    lim.unwrap(),
                    if com.notes.is_empty() { "".into() } else { format!("{}", com.notes[0]) }
                );
            }
        }
    }
}
