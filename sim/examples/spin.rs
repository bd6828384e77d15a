use narx_core::motor::*;
use narx_core::units::*;
use narx_sim::commissioning::*;
use narx_sim::plant::*;
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let mode = match args.get(1).map(|s| s.as_str()) {
        Some("ol") => Mode::OpenLoop,
        _ => Mode::Hall,
    };
    let rpm: f64 = args.get(2).map_or(2000.0, |s| s.parse().unwrap());
    let secs: f64 = args.get(3).map_or(1.5, |s| s.parse().unwrap());
    let load: f64 = args.get(4).map_or(0.0, |s| s.parse().unwrap());
    let motor = MotorConfig { static_friction: 0.002, ..MotorConfig::default() };
    let plate = Nameplate { motor, rated_current: Some(4.0), supply: 24.0 };
    let mut com = plate.commission(mode).unwrap();
    for n in &com.notes {
        println!("{n}");
    }
    if mode == Mode::OpenLoop {
        com.parameters.set(narx_core::dictionary::number::OPEN_LOOP_SPEED, rpm.abs() as i32).unwrap();
    }
    let c = Coefficients::build(&com.parameters, &Board::BENCH).map_err(|e| e.to_string()).unwrap();
    println!(
        "drive {} B, coefficients {} B",
        std::mem::size_of::<Drive>(),
        std::mem::size_of::<Coefficients>()
    );
    let mut drive = Drive::new(c);
    let mut cfg = PlantConfig::new(motor, 24.0);
    cfg.load.constant = load;
    let mut plant = Plant::new(&cfg);
    let pp = 4.0;
    for k in 0..(secs * 1e4) as u64 {
        let s = plant.sample();
        if k % 500 == 0 && k >= 5500 {
            let request = if rpm < 0.0 { Request::Reverse } else { Request::Drive };
            drive.handle_event(Event::Command(Command {
                request,
                speed: ElectricalSpeed::from_bits((rpm.abs() / 60.0 * pp * 65536.0) as i32),
            }));
        }
        let p = drive.step(&s);
        let st = drive.poll_status();
        plant.finish_period(&p);
        let o = plant.observe();
        if (k >= 5500 && k % 250 == 0)
            || (k > 5490 && k < 5500 + args.get(5).map_or(0, |s| s.parse().unwrap()))
        {
            if let Some(st) = st {
                println!(
                    "{:.4} {:?} {:?} spd {:7.1} est {:7.1} set {:7.1} u {:?} {:?} {:?} duty {:.3} I {:6.2} {:6.2} {:6.2} bus {:.2}V {:.3}A  el {:.3} ang {:.3} {:?} {:x}",
                    o.time,
                    st.state,
                    st.refusal,
                    o.speed * 9.5493,
                    f64::from(st.speed_hall.to_bits()) / 65536.0 * 60.0 / pp,
                    f64::from(st.setpoint.to_bits()) / 65536.0 * 60.0 / pp,
                    p.step,
                    p.rectification,
                    st.limiter,
                    f64::from(st.duty.to_bits()) / 32768.0,
                    o.current[0],
                    o.current[1],
                    o.current[2],
                    o.bus_voltage,
                    o.bus_current,
                    o.electrical_turns.rem_euclid(1.0),
                    f64::from(st.angle.0) / 65536.0,
                    st.faults,
                    st.extended_code
                );
            }
        }
    }
}
