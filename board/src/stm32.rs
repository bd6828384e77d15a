//! Patterns of the bridge as words of an STM32's advanced timer: TIM1 or TIM8 with complementary outputs.
//!
//! | leg | compare mode | main output, high side | complementary output, low side |
//! |---|---|---|---|
//! | off | forced inactive | enabled, inactive | off by OSSR, inactive |
//! | low | forced inactive | enabled, inactive | enabled, active |
//! | switched, both switches | PWM mode 1 | enabled | enabled, with dead time |
//! | switched, diode below | PWM mode 1 | enabled | off by OSSR, inactive |
//!
//! A leg is never left to the pins' pull-downs: every output is driven as long as MOE is set, and by the idle
//! states when it is not.

use narx_core::motor::{Leg, Rectification, Step};

/// Command to the two switches of a leg.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Gates {
    /// Both switches off.
    #[default]
    Off,
    /// Low side on.
    Low,
    /// Both sides in turn, the timer keeps the dead time.
    Complementary,
    /// High side only; the current freewheels in the diode below.
    HighOnly,
}

impl Gates {
    /// Returns the command to a leg that has this role in a step.
    pub const fn of(leg: Leg, rectification: Rectification) -> Self {
        match (leg, rectification) {
            (Leg::Floating, _) => Self::Off,
            (Leg::Low, _) => Self::Low,
            (Leg::Switched, Rectification::Synchronous) => Self::Complementary,
            (Leg::Switched, Rectification::Diode) => Self::HighOnly,
        }
    }

    /// Returns whether the leg has to be off for a dead time between `self` and `next`: the timer keeps the
    /// dead time only while both of the leg's outputs stay enabled.
    pub const fn needs_pause(self, next: Self) -> bool {
        !matches!(
            (self, next),
            (Self::Off, _)
                | (_, Self::Off)
                | (Self::Low | Self::Complementary, Self::Low | Self::Complementary)
                | (Self::HighOnly, Self::HighOnly)
        )
    }

    /// Field OCxM, with OCxPE: the duty is latched at the boundary.
    const fn mode(self) -> u32 {
        const PRELOAD: u32 = 1 << 3;
        const FORCED_INACTIVE: u32 = 0b100 << 4;
        const PWM_MODE_1: u32 = 0b110 << 4;
        PRELOAD
            | match self {
                Self::Off | Self::Low => FORCED_INACTIVE,
                Self::Complementary | Self::HighOnly => PWM_MODE_1,
            }
    }

    /// Fields CCxE and CCxNE, both active high.
    const fn enables(self) -> u32 {
        const MAIN: u32 = 1 << 0;
        const COMPLEMENTARY: u32 = 1 << 2;
        match self {
            Self::Off | Self::HighOnly => MAIN,
            Self::Low | Self::Complementary => MAIN | COMPLEMENTARY,
        }
    }
}

/// The gates of a step.
pub fn gates(step: Step, rectification: Rectification) -> [Gates; 3] {
    step.legs().map(|leg| Gates::of(leg, rectification))
}

/// The gates while those legs that need a pause have it.
pub fn pause([a, b, c]: [Gates; 3], [next_a, next_b, next_c]: [Gates; 3]) -> Option<[Gates; 3]> {
    let paused = |now: Gates, next| if now.needs_pause(next) { Gates::Off } else { now };
    let gates = [paused(a, next_a), paused(b, next_b), paused(c, next_c)];
    (gates != [a, b, c]).then_some(gates)
}

/// Words of TIM1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Registers {
    /// CCMR1: phases A and B.
    pub ccmr1: u32,
    /// CCMR2: phase C.
    pub ccmr2: u32,
    /// CCER.
    pub ccer: u32,
}

/// The words for the gates of phases A, B, C.
pub const fn registers([a, b, c]: [Gates; 3]) -> Registers {
    Registers {
        ccmr1: a.mode() | b.mode() << 8,
        ccmr2: c.mode(),
        ccer: a.enables() | b.enables() << 4 | c.enables() << 8,
    }
}

/// The field DTG for a dead time of so many counts, rounded up (RM0440, TIM1_BDTR); `None` beyond 1008.
pub const fn dead_time_code(counts: u16) -> Option<u8> {
    let code = match counts {
        0..=127 => counts,
        128..=254 => 0x80 | (counts.div_ceil(2) - 64),
        255..=504 => 0xC0 | (counts.div_ceil(8) - 32),
        505..=1008 => 0xE0 | (counts.div_ceil(16) - 32),
        _ => return None,
    };
    Some(code as u8)
}
