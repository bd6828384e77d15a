//! What a tick costs: the committed figures of `tests/golden`, side by side. Counting them needs an emulator, a C compiler and valgrind, and
//! the bench needs only Rust.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

/// Prints the table.
pub(super) fn print(root: &Path) {
    let read = |name: &str| {
        let path = root.join("tests/golden").join(name);
        fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))
    };
    let table = read("instructions.toml")
        .and_then(|instructions| table(&instructions, &read("callgrind.toml")?).ok_or("malformed".into()));
    match table {
        Ok(table) => println!("{table}"),
        Err(reason) => println!("no figures of a tick's cost: {reason}"),
    }
}

/// Instructions of many ticks.
#[derive(Clone, Copy, Default)]
struct Cost {
    ticks: i64,
    total: i64,
    worst: i64,
}

impl Cost {
    fn new(row: &toml::Value) -> Option<Self> {
        let figure = |name| row.get(name)?.as_integer();
        Some(Self { ticks: figure("ticks")?, total: figure("total")?, worst: figure("worst")? })
    }

    fn and(self, other: Self) -> Self {
        let (ticks, total) = (self.ticks + other.ticks, self.total + other.total);
        Self { ticks, total, worst: self.worst.max(other.worst) }
    }

    fn average(&self) -> f64 {
        self.total as f64 / self.ticks.max(1) as f64
    }
}

/// The kinds of rows that are printed one by one, in order.
const KINDS: [&str; 4] = ["floor", "running", "state", "plant"];

/// The bare tick that does the same task.
fn floor_of(row: &str) -> Option<&'static str> {
    match row {
        "floor.hall" | "running.hall" | "state.HallClosedLoop" => Some("hall"),
        "floor.sensorless"
        | "running.sensorless"
        | "state.SensorlessClosedLoop"
        | "state.SensorlessAutoRestart" => Some("sensorless"),
        _ => None,
    }
}

/// The text; `None` if a file is not what it should be.
fn table(instructions: &str, callgrind: &str) -> Option<String> {
    let golden: toml::Table = instructions.parse().ok()?;
    let kind = |kind: &str| -> Option<BTreeMap<String, Cost>> {
        let rows = golden.get(kind)?.as_table()?;
        rows.iter().map(|(name, row)| Some((name.clone(), Cost::new(row)?))).collect()
    };
    let floors = kind("floor")?;
    let mut text = String::from(
        "cost of a tick; not measured here, but read from tests/golden, where `cargo xtask test` compares it with what it counts\n",
    );
    // Writing to a string cannot fail.
    let _ = writeln!(
        text,
        "{:<32} {:>9} {:>8}   {:>18}",
        "instructions on a Cortex-M4F", "average", "worst", "times the C floor's"
    );
    let mut line = |name: &str, cost: Cost| {
        let _ = write!(text, "{name:<32} {:>9.1} {:>8}", cost.average(), cost.worst);
        if let Some(floor) = floor_of(name).and_then(|name| floors.get(name)) {
            let worst = cost.worst as f64 / floor.worst as f64;
            let _ = write!(text, "   {:>9.2} {worst:>8.2}", cost.average() / floor.average());
        }
        text.push('\n');
    };
    for name in KINDS {
        kind(name)?.into_iter().for_each(|(row, cost)| line(&format!("{name}.{row}"), cost));
    }
    let vectors = kind("vector")?;
    line(&format!("{} vectors", vectors.len()), vectors.into_values().fold(Cost::default(), Cost::and));
    let bytes = |name| golden.get(name)?.as_integer();
    let (state, coefficients) = (bytes("state_bytes")?, bytes("coefficients_bytes")?);
    let _ = writeln!(text, "memory of the drive: {state} bytes of state, {coefficients} of coefficients");
    let _ = writeln!(
        text,
        "floor: a bare tick in C (xtask/floor/tick.c, {})",
        golden.get("floor_compiler")?.as_str()?
    );
    let modes: toml::Table = callgrind.parse().ok()?;
    let _ =
        writeln!(text, "{:<32} {:>9} {:>8} {:>8}", "instructions on x86-64", "simulated", "control", "plant");
    for (mode, row) in &modes {
        let figure = |name| row.get(name)?.as_integer();
        let (tick, control, plant) = (figure("tick")?, figure("control")?, figure("plant")?);
        let _ = writeln!(text, "{mode:<32} {tick:>9} {control:>8} {plant:>8}");
    }
    Some(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    const CALLGRIND: &str = "[hall]\ntick = 7000\ncontrol = 600\nplant = 6000\n";

    fn golden(floor: &str) -> String {
        let row = |name: &str, worst| format!("[{name}]\nticks = 10\ntotal = 3000\nworst = {worst}\n");
        let rows: String = ["running.hall", "state.Fault", "plant.driving", "vector.a", "vector.b"]
            .map(|name| row(name, 600))
            .concat();
        format!("state_bytes = 900\ncoefficients_bytes = 1000\nfloor_compiler = \"gcc 1\"\n{rows}{floor}")
    }

    #[test]
    fn ratios_are_to_the_floor_of_the_same_task() {
        let floor = "[floor.hall]\nticks = 5\ntotal = 500\nworst = 150\n";
        let text = table(&golden(floor), CALLGRIND).unwrap();
        let words = |start: &str| -> Vec<String> {
            let line = text.lines().find(|line| line.starts_with(start)).unwrap();
            line.split_whitespace().skip(1).map(str::to_owned).collect()
        };
        assert_eq!(words("running.hall"), ["300.0", "600", "3.00", "4.00"]);
        assert_eq!(words("floor.hall"), ["100.0", "150", "1.00", "1.00"]);
        assert_eq!(words("state.Fault"), ["300.0", "600"]);
        assert_eq!(words("2 vectors"), ["vectors", "300.0", "600"]);
        assert_eq!(words("hall"), ["7000", "600", "6000"]);
    }

    #[test]
    fn a_file_without_a_floor_is_no_table() {
        assert_eq!(table(&golden(""), CALLGRIND), None);
    }
}
