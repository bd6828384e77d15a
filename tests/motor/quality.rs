//! Small tests of control quality and the start-up certificate: one motor of the market, three random ones, a
//! few cells of the grids.

use narx_core::motor::Board;
use narx_lab::certificate::{self, Certificate};
use narx_lab::quality::{self, Quality};
use narx_sim::presets::{PRESETS, Preset};
use std::path::Path;

fn committed(name: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/evidence").join(name)
}

/// Identifying fields of every row.
fn heads(quality: &Quality) -> Vec<(&str, &str, &str, &str, f64)> {
    let promised = quality.rows.iter().filter(|row| !row.of.ends_with("unseen"));
    promised
        .map(|row| (row.of.as_str(), row.mode.as_str(), row.metric.as_str(), row.unit.as_str(), row.most))
        .collect()
}

/// The committed table has the rows that the code measures, and a motor of the market misses none of the
/// promises.
#[test]
fn quality_is_measured_as_it_is_committed() {
    let motor: Vec<&Preset> = PRESETS.iter().filter(|preset| preset.name == "ec45-flat-50w-18v").collect();
    let quality = quality::measure(&Board::BENCH, &motor, 3);
    assert_eq!(quality.motors, 3, "every seed draws a motor");
    let committed = Quality::read(&committed("quality.json")).unwrap();
    assert_eq!(heads(&quality), heads(&committed));
    let missed: Vec<_> =
        quality.failures.iter().filter(|failure| !failure.command.contains("--case")).collect();
    assert!(missed.is_empty(), "{missed:#?}");
    for row in quality.rows.iter().filter(|row| row.of == "presets" && row.is_promise()) {
        assert!(row.runs > 0, "{row:?}");
        assert!(row.median <= row.p95 && row.p95 <= row.p99 && row.p99 <= row.worst, "{row:?}");
    }
}

/// In every eleventh cell of the grids the promised starts succeed, and the figures are those that are
/// committed.
#[test]
fn starts_are_certified_as_they_are_committed() {
    let motors: Vec<&'static Preset> = PRESETS.iter().filter(|preset| preset.name == "bly172s-24v").collect();
    let (certificate, picture) = certificate::measure(&Board::BENCH, &motors, 11);
    assert!(certificate.part.failures.is_empty(), "{:#?}", certificate.part.failures);
    assert!(certificate.part.is_met());
    let committed = Certificate::read(&committed("starts.json")).unwrap();
    let heads = |certificate: &Certificate| {
        let figures = certificate.part.figures.iter();
        figures.map(|figure| (figure.name.clone(), figure.unit.clone(), figure.goal)).collect::<Vec<_>>()
    };
    assert_eq!(heads(&certificate), heads(&committed));
    // The lock's torque is a limit: beyond it a start is the exception.
    let share = |from: usize| {
        let rows = certificate.breakaway.iter().skip(from).take(2);
        rows.fold((0, 0), |(tried, started), row| (tried + row.1, started + row.2))
    };
    let ((tried, started), (heavy, moved)) = (share(0), share(4));
    assert!(tried > 10 && started == tried, "{started} of {tried}");
    assert!(heavy > 1 && moved < heavy, "{moved} of {heavy}");
    assert!(picture.unwrap().contains("sensorless starts"));
}
