//! Repetition of one random plant, with every file that a run can write.

use super::start::Start;
use super::trial::Trial;
use narx_core::motor::Board;
use narx_host::csv;
use narx_sim::random_plant::{RandomPlant, Spread};
use narx_terminal::plot::{self, Caption};
use std::fs::{self, File};
use std::io::{self, BufWriter, Write as _};
use std::path::Path;

/// Runs the start of that seed on this board and writes its files. Returns true if the motor started.
pub(super) fn replay(seed: u64, board: &Board, out: &Path) -> io::Result<bool> {
    let Some(drawn) = RandomPlant::new(seed, &Spread::PROMISED, board) else {
        println!("seed {seed} draws no plant that commissioning accepts");
        return Ok(false);
    };
    let label = format!("bench case {seed}: {}", drawn.preset.name);
    let mut trial = Trial::new(&drawn.plant, &drawn.commissioning, &label, true);
    let start = Start::follow(seed, drawn, &mut trial);
    println!("{start}");
    for note in &start.drawn.commissioning.notes {
        println!("  note: {note}");
    }
    if start.started() {
        println!("closed loop after {:.2} s", start.to_closed_loop);
    }
    println!("phase current up to {:.1} A, bus up to {:.2} V", start.peak_current, trial.bus_highest);
    fs::create_dir_all(out)?;
    let trace = trial.bench.trace();
    let subtitle = start.to_string();
    let caption = Caption { title: &label, subtitle: &subtitle };
    fs::write(out.join("run.svg"), plot::svg(&trace, None, &caption).map_err(io::Error::other)?)?;
    fs::write(out.join("run.narxrec"), trial.bench.recording())?;
    let mut file = BufWriter::new(File::create(out.join("run.csv"))?);
    csv::write(&[&trace], &mut file)?;
    file.flush()?;
    println!("written to {}: run.svg run.csv run.narxrec", out.display());
    Ok(start.started())
}
