//! The picture of a made-up run.

use super::*;
use narx_sim::trace::Signal;

const SIGNALS: [Signal; 12] = [
    Signal::double("time", "s"),
    Signal::single("setpoint", "rpm"),
    Signal::single("speed", "rpm"),
    Signal::single("speed_estimated", "rpm"),
    Signal::single("state", ""),
    Signal::single("sector", ""),
    Signal::single("duty", ""),
    Signal::single("current_a", "A"),
    Signal::single("current_b", "A"),
    Signal::single("current_c", "A"),
    Signal::single("bus_current", "A"),
    Signal::single("bus_voltage", "V"),
];

/// Trace of boot, standby, a hall start to 3000 rpm with overshoot and noise, and a stop.
fn made_up(rows: u32) -> Trace {
    let mut trace = Trace::new(&SIGNALS);
    let mut angle = 0.0f64;
    let mut seed = 1u32;
    for k in 0..rows {
        let t = f64::from(k) * 1e-4;
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let noise = f64::from(seed >> 16) / 32_768.0 - 1.0;
        let on = (0.6..2.6).contains(&t);
        let setpoint = if on { (3_000.0 * (t - 0.6) / 0.8).min(3_000.0) } else { 0.0 };
        let rise = t - 0.6;
        let speed = match t {
            _ if on => setpoint * (1.0 - (-rise / 0.05).exp() * (rise * 40.0).cos()),
            _ if t >= 2.6 => 3_000.0 * (-(t - 2.6) / 0.15).exp(),
            _ => 0.0,
        };
        angle += speed / 60.0 * 4.0 * 1e-4;
        let sector = (angle * 6.0) as i64 % 6;
        let current = if on { 1.4 + 2.0 * (-rise / 0.3).exp() } else { 0.0 };
        let phase = |shift: i64| {
            let share = [1.0, 1.0, 0.0, -1.0, -1.0, 0.0][((sector + 6 - shift) % 6) as usize];
            current * share * (1.0 + 0.15 * noise)
        };
        let state = if t < 0.5 {
            0.0
        } else if on {
            5.0
        } else {
            1.0
        };
        let duty = if on { 0.04 + speed / 4_200.0 } else { 0.0 };
        let estimated = if on { speed * (1.0 + 0.01 * noise) } else { 0.0 };
        let bus = current * duty * (1.0 + 0.05 * noise);
        let sector = sector as f64;
        let [a, b, c] = [phase(0), phase(2), phase(4)];
        trace
            .push(&[t, setpoint, speed, estimated, state, sector, duty, a, b, c, bus, 48.0 - 0.1 * bus])
            .unwrap();
    }
    trace
}

#[test]
fn thirty_thousand_rows_make_a_light_picture() {
    let caption = Caption { title: "Made-up motor", subtitle: "hall sensors, 48 V supply, 0.02 N m load" };
    let picture = svg(&made_up(30_000), None, &caption).unwrap();
    if let Ok(path) = std::env::var("NARX_PLOT") {
        std::fs::write(path, &picture).unwrap();
    }
    println!("{} bytes", picture.len());
    assert!(picture.len() < 400 * 1024, "{}", picture.len());
    assert!(picture.contains("width=\"1100\""));
    for text in
        ["Made-up motor", "48 V supply", "Speed", "rpm", "bus voltage, V (right)", "Standby", "time, s"]
    {
        assert!(picture.contains(text), "{text}");
    }
}

#[test]
fn what_cannot_be_drawn_is_named() {
    let caption = Caption { title: "", subtitle: "" };
    assert_eq!(svg(&made_up(1), None, &caption), Err(PlotError::TooShort));
    let trace = Trace::new(&SIGNALS[..4]);
    assert_eq!(svg(&trace, None, &caption), Err(PlotError::Missing("bus_current")));
    // Two rows without any motion.
    assert!(svg(&made_up(2), None, &caption).is_ok());
}

/// Displacements have a panel of their own, in which each begins at its first position: before that it is
/// NaN.
#[test]
fn displacements_have_a_panel() {
    let caption = Caption { title: "", subtitle: "" };
    let mut trace = Trace::new(&["displacement_1", "displacement_2"].map(|name| Signal::single(name, "mm")));
    for k in 0..3000 {
        let angle = f64::from(k) / 50.0;
        let begun = if k < 1000 { f64::NAN } else { 0.0 };
        trace.push(&[begun + 1.0 + 0.02 * angle.cos(), begun + 0.5 + 0.01 * angle.sin()]).unwrap();
    }
    let picture = svg(&made_up(3000), Some(&trace), &caption).unwrap();
    for text in ["Displacement, um from the first position", "TX-Driver 1", "TX-Driver 2"] {
        assert!(picture.contains(text), "{text}");
    }
    assert!(!picture.contains("TX-Driver 3") && !picture.contains("NaN"));
    assert!(!svg(&made_up(3000), None, &caption).unwrap().contains("Displacement"));
}
