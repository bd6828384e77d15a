//! Patterns of the bridge as words of an STM32's advanced timer: TIM1 or TIM8 with complementary outputs.
//! And the bus current, from shunts below the legs.
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

use narx_core::motor::{Leg, Rectification, SampleMode, Step};
use narx_core::units::Duty;

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

/// Mean bus current of a period, in the unit of `shunts` times 32 768. They are what the legs of phases A,
/// B, C carry to ground in the middle of `sampled`, and `dead` is the dead time's share of the period, raw
/// U1F15.
///
/// At any instant the bus carries what all legs together carry to ground. In the on-time a switched leg
/// carries nothing to ground, and the others carry what they carry in the off-time, too: a low leg, and the
/// lower diode of a phase that was just turned off. In the off-time all legs together carry what returns to
/// the bus through an upper diode; where the on-time was sampled nobody knows that, and it counts as 0.
/// Through the dead time a current out of the switched leg flows as in the off-time, one into it as in the
/// on-time. With the bridge off there is off-time alone.
pub fn bus_current(shunts: [i32; 3], gates: [Gates; 3], duty: Duty, dead: u16, sampled: SampleMode) -> i64 {
    const WHOLE: i64 = 1 << 15;
    let is_off = gates == [Gates::Off; 3];
    let is_switched = |gates| matches!(gates, Gates::Complementary | Gates::HighOnly);
    let legs = shunts.into_iter().zip(gates);
    let in_on_time: i32 = legs.filter(|(_, gates)| !is_switched(*gates)).map(|(shunt, _)| shunt).sum();
    let in_off_time: i32 = shunts.into_iter().sum();
    let on = match i64::from(duty.to_bits()) {
        _ if is_off => 0,
        duty if !gates.contains(&Gates::Complementary) => duty,
        duty => (duty - i64::from(dead) * i64::from(in_on_time.signum())).clamp(0, WHOLE),
    };
    let off = if is_off || sampled == SampleMode::OffTime { WHOLE - on } else { 0 };
    i64::from(in_on_time) * on + i64::from(in_off_time) * off
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
