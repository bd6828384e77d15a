//! A scenario as in its file, checked as a whole before anything runs.

use super::action::{Step, StepKeys};
use super::expect::Expect;
use narx_core::commissioning::{Mode, Nameplate};
use narx_core::dictionary::{Dictionary, Parameter, Parameters};
use narx_core::motor::Board;
use narx_sim::plant::{LoadConfig, PlantConfig};
use narx_sim::presets::{PRESETS, preset};
use narx_sim::session::{PwmRateError, board_at};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;
use std::{fmt, fs};

/// A checked scenario.
#[derive(Clone, Debug)]
pub struct Scenario {
    /// Name of the file without its extension.
    pub name: String,
    /// Its purpose, in a line.
    pub title: String,
    /// Motor, supply, load and board.
    pub plant: PlantConfig,
    /// Stored parameters of the drive: commissioned, with the file's own over them.
    pub parameters: Parameters,
    /// Time from power-up to the end, s.
    pub seconds: f64,
    /// Actions in order of time.
    pub steps: Vec<Step>,
    /// Expected results.
    pub expect: Expect,
    /// Device whose inputs are recorded.
    pub of: Of,
}

/// Device whose inputs a scenario records.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Of {
    /// The drive: inputs of its control tick.
    #[default]
    Drive,
    /// The drive's node, which has no bootloader.
    Node,
    /// A TX-Driver on the same bus: node-id 5, two channels without noise, a rotary encoder.
    TxDriver,
}

/// Reason why a scenario is invalid: the file, the key, its value and the allowed values, in one line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Invalid(String);

impl fmt::Display for Invalid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Invalid {}

/// Content of the file, key by key.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Keys {
    title: String,
    motor: String,
    mode: ModeKey,
    supply: f64,
    /// PWM frequency, Hz; without it 10 kHz.
    pwm_rate: Option<u32>,
    seconds: f64,
    /// Mechanical speed of open loop, rpm; without it commissioning chooses.
    open_loop_speed: Option<f64>,
    #[serde(default)]
    load: f64,
    #[serde(default)]
    plant: PlantKeys,
    #[serde(default)]
    parameters: BTreeMap<String, f64>,
    at: Vec<StepKeys>,
    expect: Expect,
    #[serde(default)]
    of: Of,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum ModeKey {
    Hall,
    OpenLoop,
    Sensorless,
}

/// Details of the plant. A key that is left out has the plant's default, except the angle: 77 degrees is no
/// special position and not on a sector's edge. The converter has no noise unless requested: noise makes
/// recordings long.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, default)]
struct PlantKeys {
    seed: u64,
    angle_deg: f64,
    ambient: f64,
    noise: f64,
    hall_order: u8,
    hall_polarity: u8,
    hall_offset_deg: f64,
    supply_resistance: f64,
    /// Mechanical speed at power-up, rpm.
    rpm: f64,
}

impl Default for PlantKeys {
    fn default() -> Self {
        Self {
            seed: 1,
            angle_deg: 77.0,
            ambient: 25.0,
            noise: 0.0,
            hall_order: 0,
            hall_polarity: 0,
            hall_offset_deg: 0.0,
            supply_resistance: 0.1,
            rpm: 0.0,
        }
    }
}

/// Checks a value against its range; errors name the key.
pub(super) fn within(key: &str, value: f64, min: f64, max: f64, unit: &str) -> Result<f64, String> {
    if (min..=max).contains(&value) {
        Ok(value)
    } else {
        Err(format!("{key} = {value}: must be from {min} to {max} {unit}").trim_end().to_owned())
    }
}

/// Returns the number of a parameter, given by number or printed name, and a value in its unit as 32 bits.
pub(super) fn parameter(key: &str, name: &str, value: f64) -> Result<(u16, i32), String> {
    let by_number = name.parse::<u16>().ok().and_then(Dictionary::row);
    let row: &Parameter = by_number.or_else(|| Dictionary::find(name)).ok_or_else(|| {
        format!("{key} = \"{name}\": no such parameter; a number or a name of PROTOCOL.md, section 5")
    })?;
    let scale = 10_f64.powi(i32::from(row.exponent));
    let raw = (value / scale).round();
    within(
        &format!("{key} \"{name}\""),
        value,
        row.min() as f64 * scale,
        row.max() as f64 * scale,
        row.unit(),
    )?;
    Ok((row.number, raw as i64 as i32))
}

impl Scenario {
    /// Reads a file.
    ///
    /// # Errors
    /// Fails with the first error in the file.
    pub fn read(path: &Path) -> Result<Self, Invalid> {
        let name = path.file_stem().map_or("", |stem| stem.to_str().unwrap_or("")).to_owned();
        let text =
            fs::read_to_string(path).map_err(|error| Invalid(format!("{}: {error}", path.display())))?;
        Self::parse(&name, &text)
    }

    /// Parses the scenario `name` from a file's text.
    ///
    /// # Errors
    /// Fails with the first error in the text.
    pub fn parse(name: &str, text: &str) -> Result<Self, Invalid> {
        let keys: Keys = toml::from_str(text).map_err(|error| Invalid(unreadable(name, text, &error)))?;
        Self::checked(name, keys).map_err(|reason| Invalid(format!("{name}.toml: {reason}")))
    }

    fn checked(name: &str, keys: Keys) -> Result<Self, String> {
        let preset = preset(&keys.motor).ok_or_else(|| {
            let names: Vec<&str> = PRESETS.iter().map(|preset| preset.name).collect();
            format!("motor = \"{}\": unknown motor; one of {}", keys.motor, names.join(", "))
        })?;
        let seconds = within("seconds", keys.seconds, 0.6, 10.0, "s")?;
        let plate = Nameplate {
            motor: preset.motor.figures(),
            rated_current: preset.data.rated_current,
            supply: within("supply", keys.supply, 18.0, 60.0, "V")?,
            open_loop_speed: keys.open_loop_speed,
        };
        let mode = match keys.mode {
            ModeKey::Hall => Mode::Hall,
            ModeKey::OpenLoop => Mode::OpenLoop,
            ModeKey::Sensorless => Mode::Sensorless,
        };
        let board = keys.pwm_rate.map_or(Ok(Board::BENCH), |rate| {
            board_at(rate).ok_or_else(|| format!("pwm_rate = {rate}: {PwmRateError}"))
        })?;
        let commissioned = plate.commission_on(&board, mode, None);
        let commissioned = commissioned.map_err(|error| format!("motor {}: {error}", preset.name))?;
        let mut parameters = commissioned.parameters;
        for (name, value) in &keys.parameters {
            let (number, raw) = parameter("parameters", name, *value)?;
            parameters.set(number, raw).map_err(|error| format!("parameters: {error}"))?;
        }
        let mut plant =
            keys.plant.config(PlantConfig { board, ..PlantConfig::new(preset.motor, keys.supply) })?;
        plant.load = LoadConfig { constant: within("load", keys.load, 0.0, 10.0, "N m")?, ..plant.load };
        let steps: Vec<Step> =
            keys.at.into_iter().map(|step| step.checked(seconds)).collect::<Result<_, _>>()?;
        if !steps.is_sorted_by(|a, b| a.time <= b.time) {
            return Err("at: times must not fall".into());
        }
        keys.expect.check()?;
        Ok(Self {
            name: name.to_owned(),
            title: keys.title,
            plant,
            parameters,
            seconds,
            steps,
            expect: keys.expect,
            of: keys.of,
        })
    }
}

impl PlantKeys {
    fn config(&self, mut plant: PlantConfig) -> Result<PlantConfig, String> {
        plant.seed = self.seed;
        plant.angle_deg = within("plant.angle_deg", self.angle_deg, 0.0, 360.0, "degrees")?;
        plant.ambient = within("plant.ambient", self.ambient, -55.0, 250.0, "degrees C")?;
        plant.converter.noise = within("plant.noise", self.noise, 0.0, 100.0, "codes")?;
        plant.hall.order = within("plant.hall_order", f64::from(self.hall_order), 0.0, 5.0, "")? as u8;
        plant.hall.polarity =
            within("plant.hall_polarity", f64::from(self.hall_polarity), 0.0, 7.0, "")? as u8;
        plant.hall.offset_deg =
            within("plant.hall_offset_deg", self.hall_offset_deg, -180.0, 180.0, "degrees")?;
        plant.speed =
            within("plant.rpm", self.rpm, -20_000.0, 20_000.0, "rpm")? / 60.0 * core::f64::consts::TAU;
        plant.supply.resistance =
            within("plant.supply_resistance", self.supply_resistance, 0.0, 10.0, "ohm")?;
        Ok(plant)
    }
}

/// Formats the error of the TOML reader in one line, with the line of the file that it concerns.
fn unreadable(name: &str, text: &str, error: &toml::de::Error) -> String {
    let start = error.span().map_or(0, |span| span.start).min(text.len());
    let number = text[..start].matches('\n').count() + 1;
    let line = text.lines().nth(number - 1).unwrap_or("").trim();
    format!("{name}.toml, line {number}, {line}: {}", error.message().replace('\n', " "))
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = r#"
title = "t"
motor = "bly172s-24v"
mode = "hall"
supply = 24
seconds = 1.0
at = [{ time = 0.6, start = 1000 }, { time = 0.7, inject = { fault = "leak", value = 2.0 } }]
expect = { states = ["Initialization", "Standby"] }
"#;

    #[test]
    fn a_good_one_is_read() {
        let scenario = Scenario::parse("good", GOOD).unwrap();
        assert_eq!((scenario.steps.len(), scenario.seconds), (2, 1.0));
    }

    /// Every refusal is one line that names file, key and value, and the allowed values.
    #[test]
    fn refusals() {
        for (from, to, said) in [
            ("supply = 24", "supply = 12", "bad.toml: supply = 12: must be from 18 to 60 V"),
            (
                "supply = 24",
                "suply = 24",
                "bad.toml, line 5, suply = 24: unknown field `suply`, expected one of",
            ),
            ("supply = 24", "supply = \"x\"", "bad.toml, line 5, supply = \"x\": invalid type: string"),
            (
                "supply = 24",
                "supply = 24\npwm_rate = 60000",
                "bad.toml: pwm_rate = 60000: must be a whole number from 8000 to 50000 Hz",
            ),
            ("supply = 24", "supply = nan", "bad.toml: supply = NaN: must be from 18 to 60 V"),
            ("bly172s-24v", "mn7005", "bad.toml: motor = \"mn7005\": unknown motor; one of ec45"),
            (
                "\"hall\"",
                "\"foc\"",
                "bad.toml, line 4, mode = \"foc\": unknown variant `foc`, expected one of",
            ),
            ("seconds = 1.0", "seconds = 99", "bad.toml: seconds = 99: must be from 0.6 to 10 s"),
            ("time = 0.6", "time = 1.6", "bad.toml: at.time = 1.6: must be from 0 to 1 s"),
            ("time = 0.7", "time = 0.2", "bad.toml: at: times must not fall"),
            ("start = 1000", "start = 70000", "bad.toml: at.start = 70000: must be from -65535 to 65535 rpm"),
            ("start = 1000", "strat = 1000", "bad.toml, line 7"),
            (
                "start = 1000",
                "start = 1, stop = true",
                "bad.toml: at.time = 0.6: exactly one action, there are 2",
            ),
            (
                "start = 1000",
                "set = { parameter = \"x\", value = 1 }",
                "bad.toml: at.set = \"x\": no such parameter",
            ),
            (
                "start = 1000",
                "set = { parameter = \"114\", value = 0 }",
                "bad.toml: at.set \"114\" = 0: must be from 1 to 60000 ms",
            ),
            ("\"leak\"", "\"leek\"", "bad.toml: at.inject.fault = \"leek\": unknown; one of ambient"),
            (
                ", value = 2.0",
                "",
                "bad.toml: at.inject.fault = \"leak\": needs a value: must be a number from",
            ),
            (
                "value = 2.0",
                "value = -2",
                "bad.toml: at.inject.fault = \"leak\": value -2: must be a number from 0.01 to 1000 ohm",
            ),
            ("\"Standby\"", "\"Stand\"", "bad.toml, line 8"),
        ] {
            let text = GOOD.replace(from, to);
            assert_ne!(text, GOOD);
            let refused = Scenario::parse("bad", &text).unwrap_err().to_string();
            assert!(refused.starts_with(said), "{refused}\nexpected {said}");
            assert!(!refused.contains('\n'), "{refused}");
        }
    }
}
