//! Motors as typed: the name of a preset, or a file of figures.

use crate::setup::Refused;
use narx_sim::plant::{BackEmf, LoadConfig, MotorConfig};
use narx_sim::presets::{PRESETS, preset};
use std::fs;

/// Supply of a motor whose nominal voltage is not known, V, as of `narx.Bench`.
const SUPPLY: f64 = 48.0;

/// A motor, and what a data sheet says of it.
#[derive(Debug)]
pub(crate) struct NamedMotor {
    /// Maker and part, or the file's name.
    pub(crate) title: String,
    pub(crate) motor: MotorConfig,
    /// V.
    pub(crate) nominal_voltage: f64,
    /// A.
    pub(crate) rated_current: Option<f64>,
    /// Largest set-point, rpm.
    pub(crate) speed_max: Option<f64>,
    pub(crate) hall_offset_deg: f64,
}

/// Figures of a motor's file, in the names and units of the Python class `narx.Motor`.
#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct Figures {
    pole_pairs: u8,
    resistance: f64,
    inductance: f64,
    torque_constant: f64,
    inertia: f64,
    #[serde(default)]
    static_friction: f64,
    #[serde(default)]
    viscous_friction: f64,
    #[serde(default)]
    back_emf: Shape,
    #[serde(default)]
    hall_offset_deg: f64,
    rated_current: Option<f64>,
    max_speed: Option<f64>,
}

#[derive(Clone, Copy, Default, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
enum Shape {
    #[default]
    Trapezoidal,
    Sinusoidal,
}

impl NamedMotor {
    /// Finds the preset of this name; reads the file if the name ends in `.toml`.
    pub(crate) fn find(name: &str) -> Result<Self, Refused> {
        if name.ends_with(".toml") {
            return Self::read(name).map_err(|reason| Refused(format!("--motor {name}: {reason}")));
        }
        let Some(preset) = preset(name) else {
            let names: Vec<&str> = PRESETS.iter().map(|preset| preset.name).collect();
            return Err(Refused(format!(
                "--motor {name}: unknown motor; a file of figures (.toml), or one of {}",
                names.join(", ")
            )));
        };
        Ok(Self {
            title: format!("{} {}", preset.maker, preset.part),
            motor: preset.motor,
            nominal_voltage: preset.data.nominal_voltage,
            rated_current: preset.data.rated_current,
            speed_max: None,
            hall_offset_deg: 0.0,
        })
    }

    /// Reads a motor's file. A refusal is one line.
    fn read(path: &str) -> Result<Self, String> {
        let text = fs::read_to_string(path).map_err(|error| error.to_string())?;
        let figures: Figures = toml::from_str(&text).map_err(|error| error.message().replace('\n', " "))?;
        figures.check()?;
        let trapezoidal = MotorConfig::default().back_emf;
        Ok(Self {
            title: path.to_owned(),
            motor: MotorConfig {
                pole_pairs: figures.pole_pairs,
                resistance: figures.resistance,
                inductance: figures.inductance,
                torque_constant: figures.torque_constant,
                inertia: figures.inertia,
                static_friction: figures.static_friction,
                viscous_friction: figures.viscous_friction,
                back_emf: match figures.back_emf {
                    Shape::Trapezoidal => trapezoidal,
                    Shape::Sinusoidal => BackEmf::Sinusoidal,
                },
                ..MotorConfig::default()
            },
            nominal_voltage: SUPPLY,
            rated_current: figures.rated_current,
            speed_max: figures.max_speed,
            hall_offset_deg: figures.hall_offset_deg,
        })
    }
}

impl Figures {
    /// Checks the ranges, which are those of `narx.Motor`.
    fn check(&self) -> Result<(), String> {
        if self.pole_pairs == 0 {
            return Err(format!("pole_pairs 0: must be a whole number from 1 to {}", u8::MAX));
        }
        for (name, value, unit) in [
            ("resistance", Some(self.resistance), "ohm"),
            ("inductance", Some(self.inductance), "H"),
            ("torque_constant", Some(self.torque_constant), "N m/A"),
            ("inertia", Some(self.inertia), "kg m2"),
            ("rated_current", self.rated_current, "A"),
            ("max_speed", self.max_speed, "rpm"),
        ] {
            if let Some(value) = value.filter(|value| !(value.is_finite() && *value > 0.0)) {
                return Err(format!("{name} {value} {unit}: must be a finite number above 0"));
            }
        }
        for (name, value, unit) in [
            ("static_friction", self.static_friction, "N m"),
            ("viscous_friction", self.viscous_friction, "N m s/rad"),
        ] {
            if !(0.0..=LoadConfig::MAX).contains(&value) {
                return Err(format!("{name} {value} {unit}: must be a number from 0 to {}", LoadConfig::MAX));
            }
        }
        if !self.hall_offset_deg.is_finite() {
            return Err(format!("hall_offset_deg {} degrees: must be a finite number", self.hall_offset_deg));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::env;

    const MOTOR: &str =
        "pole_pairs = 8\nresistance = 0.447\ninductance = 2.43e-4\ntorque_constant = 0.0295\n";

    /// Reads a file with this text.
    fn of(name: &str, text: &str) -> Result<NamedMotor, String> {
        let path = env::temp_dir().join(format!("narx-{}-{name}.toml", std::process::id()));
        fs::write(&path, text).unwrap();
        let path = path.to_str().unwrap().to_owned();
        let found = NamedMotor::find(&path).map_err(|refused| refused.to_string().replace(&path, "M"));
        fs::remove_file(path).unwrap();
        found
    }

    #[test]
    fn a_file_has_the_figures_of_a_motor() {
        let more = "inertia = 1.35e-5\nback_emf = \"sinusoidal\"\nrated_current = 3.68\nmax_speed = 4000\n";
        let found = of("figures", &format!("{MOTOR}{more}")).unwrap();
        assert_eq!(found.motor.pole_pairs, 8);
        assert_eq!(found.motor.resistance, 0.447);
        assert_eq!(found.motor.back_emf, BackEmf::Sinusoidal);
        assert_eq!(found.motor.static_friction, 0.0);
        assert_eq!((found.rated_current, found.speed_max), (Some(3.68), Some(4000.0)));
    }

    #[test]
    fn a_file_that_is_no_motor_is_refused_in_one_line() {
        for (place, (more, expected)) in [
            ("", "--motor M: missing field `inertia`"),
            ("inertia = -1.0", "--motor M: inertia -1 kg m2: must be a finite number above 0"),
            ("inertia = nan", "--motor M: inertia NaN kg m2: must be"),
            ("inertia = 1e-5\nmass = 2", "--motor M: unknown field `mass`, expected one of"),
            ("inertia = 1e-5\nback_emf = \"square\"", "--motor M: unknown variant `square`, expected"),
            (
                "inertia = 1e-5\nstatic_friction = -1",
                "--motor M: static_friction -1 N m: must be a number from 0",
            ),
            ("inertia = 1e-5\nhall_offset_deg = inf", "--motor M: hall_offset_deg inf degrees: must be"),
            ("inertia = ", "--motor M: "),
        ]
        .into_iter()
        .enumerate()
        {
            let refused = of(&format!("refused{place}"), &format!("{MOTOR}{more}\n")).unwrap_err();
            assert!(refused.starts_with(expected), "{refused}");
            assert!(!refused.contains('\n'), "{refused}");
        }
        let refused = NamedMotor::find("nowhere.toml").unwrap_err().to_string();
        assert!(refused.starts_with("--motor nowhere.toml: No such file"), "{refused}");
    }
}
