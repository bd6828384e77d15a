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

    pub(crate) fn bus_voltage(&self, volts: f64, random: &mut Random) -> u16 {
        self.code(self.bus_voltage, volts, self.config.bus_voltage_offset, random)
    }

    pub(crate) fn phase_voltage(&self, phase: usize, volts: f64, random: &mut Random) -> u16 {
        self.code(self.phase_voltage, volts, self.config.phase_voltage_offset[phase], random)
    }

    pub(crate) fn bus_current(&self, amps: f64, random: &mut Random) -> u16 {
        self.code(self.bus_current, amps, self.config.bus_current_offset, random)
    }

    fn code(&self, scale: Scale, value: f64, offset: f64, random: &mut Random) -> u16 {
        let noise = self.config.noise * random.gaussian();
        // Rounded to nearest by the cast, which truncates and saturates.
        let code = scale.zero + value * scale.codes_per_unit + offset + noise + 0.5;
        (code as u16).min(FrontEnd::CODE_MAX)
    }
}
