//! The analogue-to-digital converter: scale, offset, noise, quantisation, saturation.

use super::config::ConverterConfig;
use crate::random::Random;
use narx_core::motor::{Channel, FrontEnd};

/// Converts volts and amperes to codes.
#[derive(Clone, Debug)]
pub(crate) struct Converter {
    config: ConverterConfig,
    bus_voltage: Scale,
    phase_voltage: Scale,
    bus_current: Scale,
}

/// Converted samples.
pub(crate) struct Codes {
    pub(crate) bus_voltage: u16,
    pub(crate) phase_voltage: [u16; 3],
    pub(crate) bus_current: u16,
}

#[derive(Clone, Copy, Debug)]
struct Scale {
    zero: f64,
    codes_per_unit: f64,
}

impl Scale {
    fn new(channel: &Channel) -> Self {
        Self { zero: f64::from(channel.zero), codes_per_unit: 1e6 / f64::from(channel.micro_per_code) }
    }
}

impl Converter {
    pub(crate) fn new(config: ConverterConfig, front_end: &FrontEnd) -> Self {
        Self {
            config,
            bus_voltage: Scale::new(&front_end.bus_voltage),
            phase_voltage: Scale::new(&front_end.phase_voltage),
            bus_current: Scale::new(&front_end.bus_current),
        }
    }

    pub(crate) fn skew(&self) -> u16 {
        self.config.skew
    }

    /// Codes of bus voltage, three phase voltages and bus current, of volts and amperes.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub(crate) fn convert(&self, bus: f64, phases: &[f64; 3], amps: f64, random: &mut Random) -> Codes {
        let [[first, second], [third, fourth], [fifth, _]] = [(); 3].map(|()| random.gaussians());
        let offset = &self.config.phase_voltage_offset;
        let phase = |x: usize, noise: f64| self.code(self.phase_voltage, phases[x], offset[x], noise);
        Codes {
            bus_voltage: self.code(self.bus_voltage, bus, self.config.bus_voltage_offset, first),
            phase_voltage: [phase(0, second), phase(1, third), phase(2, fourth)],
            bus_current: self.code(self.bus_current, amps, self.config.bus_current_offset, fifth),
        }
    }

    /// `noise` has a standard deviation of 1.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    fn code(&self, scale: Scale, value: f64, offset: f64, noise: f64) -> u16 {
        // Rounded to nearest by the cast, which truncates and saturates.
        let code = scale.zero + value * scale.codes_per_unit + offset + self.config.noise * noise + 0.5;
        (code as u16).min(FrontEnd::CODE_MAX)
    }
}
