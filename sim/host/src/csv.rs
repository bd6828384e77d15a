//! Traces as comma-separated values: the signals' names, then one row per control tick.

use narx_sim::trace::{Column, Trace};
use std::io::{self, Write};

/// Writes traces of the same ticks side by side, as many rows as the shortest has. Every number is read back
/// as exactly the same value.
pub fn write(traces: &[&Trace], mut out: impl Write) -> io::Result<()> {
    let signals = traces.iter().flat_map(|trace| trace.signals());
    let names: Vec<&str> = signals.map(|signal| signal.name).collect();
    writeln!(out, "{}", names.join(","))?;
    let columns: Vec<&Column> = traces.iter().flat_map(|trace| trace.columns()).collect();
    for row in 0..traces.iter().map(|trace| trace.len()).min().unwrap_or(0) {
        for (place, column) in columns.iter().enumerate() {
            if place > 0 {
                write!(out, ",")?;
            }
            // The shortest digits that identify the value in its own precision.
            match column {
                Column::Single(values) => write!(out, "{}", values[row])?,
                Column::Double(values) => write!(out, "{}", values[row])?,
            }
        }
        writeln!(out)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use narx_sim::trace::Signal;

    #[test]
    fn rows_read_back_to_the_same_values() {
        let mut trace = Trace::new(&[Signal::double("time", "s"), Signal::single("bus_current", "A")]);
        let rows = [[0.0, -0.1], [0.0001, 1.5e-7], [0.1 + 0.2, 1e9], [3.0, f64::from(1.0f32 / 3.0)]];
        for row in &rows {
            trace.push(row).unwrap();
        }
        let mut bytes = Vec::new();
        write(&[&trace], &mut bytes).unwrap();
        let text = String::from_utf8(bytes).unwrap();
        let mut lines = text.lines();
        assert_eq!(lines.next(), Some("time,bus_current"));
        for (row, line) in rows.iter().zip(&mut lines) {
            let (time, current) = line.split_once(',').unwrap();
            assert_eq!(time.parse::<f64>().unwrap(), row[0]);
            assert_eq!(current.parse::<f32>().unwrap(), row[1] as f32);
        }
        assert_eq!(lines.next(), None);
    }

    #[test]
    fn traces_stand_side_by_side() {
        let [mut first, mut second] = ["one", "two"].map(|name| Trace::new(&[Signal::single(name, "")]));
        (0..3).for_each(|row| first.push(&[f64::from(row)]).unwrap());
        (5..7).for_each(|row| second.push(&[f64::from(row)]).unwrap());
        let mut bytes = Vec::new();
        write(&[&first, &second], &mut bytes).unwrap();
        assert_eq!(String::from_utf8(bytes).unwrap(), "one,two\n0,5\n1,6\n");
    }
}
