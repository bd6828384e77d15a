//! Commissioning: the parameters of a drive for a motor.

use crate::device::narx_stored_t;
use crate::identification::narx_identified_t;
use crate::pointer;
use crate::status::narx_status_t::{self, *};
use crate::text;
use core::ffi::c_char;
use core::fmt;
use narx_core::commissioning::{Commissioning, Mode, Motor, Nameplate, SpeedLoop, WRITTEN};
use narx_core::dictionary::Parameters;
use narx_core::motor::Board;

/// Number of parameters that narx_commission writes.
pub const NARX_COMMISSIONED: usize = 31;
/// Number of parameters that narx_speed_loop writes.
pub const NARX_SPEED_LOOP_PARAMETERS: usize = 6;

const _: () = assert!(
    NARX_COMMISSIONED == WRITTEN.len() && NARX_SPEED_LOOP_PARAMETERS == SpeedLoop::WRITTEN.len(),
    "the header has these constants as plain numbers: set them to the core's"
);

/// Control mode for which a drive is commissioned.
#[repr(u8)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum narx_commissioning_mode_t {
    /// Hall closed loop.
    Hall = 0,
    /// Sensorless closed loop, through open loop.
    Sensorless = 1,
    /// Open loop only.
    OpenLoop = 2,
}

/// A motor, its supply and its mode. Resistance, inductance and torque constant are line to line, in the DC
/// (six-step) convention: V = R I + k w, T = k I.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_nameplate_t {
    /// Ohm.
    pub resistance: f64,
    /// H.
    pub inductance: f64,
    /// N m/A, which is the back-EMF constant, V s/rad.
    pub torque_constant: f64,
    /// Of the rotor and what is coupled to it, kg m2.
    pub inertia: f64,
    /// Coulomb friction, N m; 0 if it is not known.
    pub static_friction: f64,
    /// Viscous friction, N m s/rad; 0 if it is not known.
    pub viscous_friction: f64,
    /// Rated DC current, A; 0 for the current that heats the winding by 6 W, at most 6 A.
    pub rated_current: f64,
    /// Supply voltage, 18 to 60 V.
    pub supply: f64,
    /// Largest set-point, mechanical rpm; 0 for the largest that motor and drive allow.
    pub speed_max: f64,
    /// PWM frequency of the board, 8 000 to 50 000 Hz; 0 for 10 000.
    pub pwm_rate: u32,
    /// Pole pairs, 1 or more.
    pub pole_pairs: u8,
    /// A narx_commissioning_mode_t.
    pub mode: u8,
}

/// Parameters for a motor: write each with NARX_REQUEST_KIND_WRITE, or give them to narx_drive_init_stored.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_commissioned_t {
    /// The parameters, raw.
    pub parameters: [narx_stored_t; NARX_COMMISSIONED],
    /// Smallest set-point, mechanical rpm.
    pub speed_min: f64,
    /// Largest set-point, mechanical rpm.
    pub speed_max: f64,
    /// Mean phase current that the limits leave, A.
    pub phase_current: f64,
    /// Rated DC current, given or estimated, A.
    pub rated_current: f64,
}

/// A speed loop.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_speed_loop_t {
    /// Its gains and slowest set-point, raw.
    pub parameters: [narx_stored_t; NARX_SPEED_LOOP_PARAMETERS],
    /// Frequency at which the open loop has a gain of 1, Hz.
    pub bandwidth: f64,
    /// Phase margin at the slowest set-point, degrees; it is larger at every other.
    pub phase_margin: f64,
    /// Proportional gain, V s/rad.
    pub kp: f64,
    /// Integral gain, V/rad.
    pub ki: f64,
}

/// Writes the measured figures and the supply into a nameplate; its rated current, largest set-point and PWM
/// rate become 0, its mode stays. Returns NARX_ERROR_ARGUMENT for a rotor that was held.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_nameplate_from_identified(
    nameplate: *mut narx_nameplate_t,
    identified: *const narx_identified_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        let found = pointer::read(identified)?;
        let mode = pointer::read(nameplate.cast_const())?.mode;
        if found.turned == 0 {
            return Err(NARX_ERROR_ARGUMENT);
        }
        let filled = narx_nameplate_t {
            resistance: found.resistance.value,
            inductance: found.inductance.value,
            torque_constant: found.torque_constant.value,
            inertia: found.inertia.value,
            static_friction: found.static_friction,
            viscous_friction: found.viscous_friction,
            rated_current: 0.0,
            supply: found.supply,
            speed_max: 0.0,
            pwm_rate: 0,
            pole_pairs: found.pole_pairs,
            mode,
        };
        pointer::write(nameplate, filled)
    };
    pointer::status(run())
}

/// Computes the parameters of a drive for a motor, by the design rules. `text`, of `size` bytes, gets a line
/// for each limit of the drive that holds the motor back; for NARX_ERROR_COMMISSIONING, a motor or a supply
/// that the drive cannot run, it gets the reason. It may be NULL if `size` is 0. Returns NARX_ERROR_ARGUMENT
/// for an undefined mode, NARX_ERROR_BOARD for a PWM rate. Not for an interrupt.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_commission(
    nameplate: *const narx_nameplate_t,
    commissioned: *mut narx_commissioned_t,
    text: *mut c_char,
    size: usize,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        let given = pointer::read(nameplate)?;
        pointer::check(commissioned)?;
        let mode = mode(given.mode)?;
        let board = match given.pwm_rate {
            0 => Some(Board::BENCH),
            rate => Board::BENCH.at_rate(rate),
        };
        let board = board.ok_or(NARX_ERROR_BOARD)?;
        let positive = |value: f64| (value != 0.0).then_some(value);
        let plate = Nameplate {
            motor: motor(given),
            rated_current: positive(given.rated_current),
            supply: given.supply,
            open_loop_speed: None,
        };
        match plate.commission_on(&board, mode, positive(given.speed_max)) {
            Ok(found) => {
                text::write(text, size, Notes(&found))?;
                pointer::write(commissioned, (&found).into())
            }
            Err(reason) => {
                text::write(text, size, reason)?;
                Err(NARX_ERROR_COMMISSIONING)
            }
        }
    };
    pointer::status(run())
}

/// Computes a speed loop for a motor, with set-points from `speed_min`, mechanical rpm, on, and a bandwidth,
/// Hz; a bandwidth of 0 asks for the fastest that leaves 60 degrees of phase margin. For
/// NARX_ERROR_COMMISSIONING `text`, of `size` bytes, gets the reason; it may be NULL if `size` is 0.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_speed_loop(
    nameplate: *const narx_nameplate_t,
    speed_min: f64,
    bandwidth: f64,
    speed_loop: *mut narx_speed_loop_t,
    text: *mut c_char,
    size: usize,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        let motor = motor(pointer::read(nameplate)?);
        pointer::check(speed_loop)?;
        let failed = |reason: &dyn fmt::Display| {
            text::write(text, size, reason).err().unwrap_or(NARX_ERROR_COMMISSIONING)
        };
        let found = motor
            .speed_loop(speed_min, (bandwidth != 0.0).then_some(bandwidth))
            .map_err(|reason| failed(&reason))?;
        let mut written = Parameters::new();
        found.write(&mut written).map_err(|reason| failed(&reason))?;
        let SpeedLoop { bandwidth, phase_margin, kp, ki, .. } = found;
        let parameters = stored(&written, SpeedLoop::WRITTEN);
        pointer::write(speed_loop, narx_speed_loop_t { parameters, bandwidth, phase_margin, kp, ki })
    };
    pointer::status(run())
}

fn mode(number: u8) -> Result<Mode, narx_status_t> {
    use narx_commissioning_mode_t as Number;
    match number {
        number if number == Number::Hall as u8 => Ok(Mode::Hall),
        number if number == Number::Sensorless as u8 => Ok(Mode::Sensorless),
        number if number == Number::OpenLoop as u8 => Ok(Mode::OpenLoop),
        _ => Err(NARX_ERROR_ARGUMENT),
    }
}

fn motor(given: &narx_nameplate_t) -> Motor {
    Motor {
        pole_pairs: given.pole_pairs,
        resistance: given.resistance,
        inductance: given.inductance,
        torque_constant: given.torque_constant,
        inertia: given.inertia,
        static_friction: given.static_friction,
        viscous_friction: given.viscous_friction,
    }
}

fn stored<const N: usize>(parameters: &Parameters, numbers: [u16; N]) -> [narx_stored_t; N] {
    numbers.map(|number| narx_stored_t { number, value: parameters.value(number).unwrap_or_default() })
}

impl From<&Commissioning> for narx_commissioned_t {
    fn from(found: &Commissioning) -> Self {
        Self {
            parameters: stored(&found.parameters, WRITTEN),
            speed_min: found.speed_min,
            speed_max: found.speed_max,
            phase_current: found.phase_current,
            rated_current: found.rated_current,
        }
    }
}

/// The notes, a line each.
struct Notes<'a>(&'a Commissioning);

impl fmt::Display for Notes<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, note) in self.0.notes.iter().enumerate() {
            write!(f, "{}{note}", if index > 0 { "\n" } else { "" })?;
        }
        Ok(())
    }
}
