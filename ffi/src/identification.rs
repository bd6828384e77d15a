//! The identification of a motor by its drive.

use crate::handle::{self, Handle};
use crate::master::narx_master_t;
use crate::pointer;
use crate::status::narx_status_t::{self, *};
use crate::text;
use core::ffi::c_char;
use narx_core::identification::{Asked, Figure, Identification, IdentificationError, Identified, Stage};
use narx_core::master::RequestError;

/// 64-bit words of an identification on any processor.
pub const NARX_IDENTIFICATION_WORDS: usize = 1512;

/// The identification of one motor: memory that the caller owns. Its content is private to the library; it
/// may be copied and moved between calls. Calls for one identification, or for its master, must not interrupt
/// each other.
#[repr(C)]
pub struct narx_identification_t {
    /// Private.
    words: [u64; NARX_IDENTIFICATION_WORDS],
}

const _: () = handle::assert_fits::<narx_identification_t>();

/// An identification, and its last error, for the caller who wants to read it.
pub(crate) struct WithError {
    identification: Identification,
    error: Option<IdentificationError>,
}

impl Handle for narx_identification_t {
    type Object = WithError;
    const MARK: u32 = u32::from_be_bytes(*b"nxId");
}

/// Facts that the user knows of the motor, and limits of its identification.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_identification_config_t {
    /// Largest phase current, A, at most 6; 0, the default, for the current whose heat in the winding is 6 W,
    /// 6 A at most.
    pub current: f64,
    /// Resistance of two switches of the drive, ohm, below 1; default that of narx's own board, 0.04. It is
    /// taken off what is measured.
    pub bridge: f64,
    /// Pole pairs, 1 to 50; 0, the default: they are counted, with narx_identification_mark.
    pub pole_pairs: u8,
    /// Not 0: the rotor stays still, and resistance and inductance alone are measured; default 0.
    pub hold: u8,
    /// Not 0: the hall sensors are calibrated, too; not with `hold`; default 0.
    pub halls: u8,
}

/// A measured figure.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct narx_figure_t {
    /// The value.
    pub value: f64,
    /// The truth is within this of the value for about 95 of 100 motors.
    pub uncertainty: f64,
}

/// Figures of a motor as its drive has measured them, at the temperature that the motor had.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct narx_identified_t {
    /// Ambient temperature at the drive when the measurement began, degrees Celsius: that of a motor that has
    /// rested in the same room. NAN if the drive does not broadcast it.
    pub temperature: f64,
    /// Bus voltage without load, V.
    pub supply: f64,
    /// Largest phase current of the identification: the given one, or what the heat allows, A.
    pub current: f64,
    /// Line to line, ohm.
    pub resistance: narx_figure_t,
    /// Line to line, H.
    pub inductance: narx_figure_t,
    /// N m/A, which is the back-EMF constant, V s/rad. This and what follows is 0 for a rotor that was held.
    pub torque_constant: narx_figure_t,
    /// Of the rotor and what is coupled to it, kg m2.
    pub inertia: narx_figure_t,
    /// Friction at `speed`, N m.
    pub friction: narx_figure_t,
    /// Its constant part, N m.
    pub static_friction: f64,
    /// Its part that grows with the speed, N m s/rad.
    pub viscous_friction: f64,
    /// Speed to which `friction` belongs, the largest that was used, rad/s.
    pub speed: f64,
    /// Pole pairs, as given or as counted.
    pub pole_pairs: u8,
    /// Not 0: the rotor has turned.
    pub turned: u8,
    /// Not 0: the hall sensors were calibrated, and the drive keeps what follows.
    pub calibrated: u8,
    /// Permutation of the hall lines, 0 to 5 (parameter 262).
    pub hall_order: u8,
    /// Hall lines that are inverted, a bit each (parameter 263).
    pub hall_polarity: u8,
    /// Offset of the hall edges, electrical degrees (parameter 80).
    pub hall_offset: f64,
}

/// Part of an identification that is under way.
#[repr(u8)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum narx_identification_stage_t {
    /// Reads what the drive is.
    Asks = 0,
    /// Holds the rotor: resistance and inductance.
    Holds = 1,
    /// Turns the rotor and lets it coast: back-EMF constant.
    Spins = 2,
    /// Accelerates it and lets it coast: inertia and friction.
    Accelerates = 3,
    /// Turns the rotor one electrical revolution each way: hall sensors.
    Calibrates = 4,
    /// Stops the motor and restores the parameters.
    Restores = 5,
    /// Turns the rotor slowly, in steps, and waits for narx_identification_mark: pole pairs. It comes after
    /// Holds.
    Counts = 6,
}

/// Writes the default configuration, as a start for your own. Its pole pairs are counted.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_identification_config_default(
    config: *mut narx_identification_config_t,
) -> narx_status_t {
    let Asked { pole_pairs, current, bridge, turn, halls } = Asked::new(None);
    let plain = narx_identification_config_t {
        current: current.unwrap_or(0.0),
        bridge,
        pole_pairs: pole_pairs.unwrap_or(0),
        hold: (!turn).into(),
        halls: halls.into(),
    };
    // SAFETY: the rule for pointers at the head of narx.h.
    pointer::status(unsafe { pointer::write(config, plain) })
}

/// Returns the bytes that an identification needs on this processor: at most sizeof(narx_identification_t).
/// Any context.
#[unsafe(no_mangle)]
pub extern "C" fn narx_identification_size() -> usize {
    handle::size::<narx_identification_t>()
}

/// Makes an identification in `size` bytes of memory: sizeof(narx_identification_t), or
/// narx_identification_size() of your own. It begins with the first step; the drive must then be in Standby,
/// with the shaft at rest. Returns NARX_ERROR_ARGUMENT for a value outside its range.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_identification_init(
    identification: *mut narx_identification_t,
    size: usize,
    config: *const narx_identification_config_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        let config = pointer::read(config)?;
        let asked = Asked {
            pole_pairs: (config.pole_pairs != 0).then_some(config.pole_pairs),
            current: (config.current != 0.0).then_some(config.current),
            bridge: config.bridge,
            turn: config.hold == 0,
            halls: config.halls != 0,
        };
        let made = Identification::new(asked).map_err(|_| NARX_ERROR_ARGUMENT)?;
        handle::init(identification, size, || Ok(WithError { identification: made, error: None }))
    };
    pointer::status(run())
}

/// Goes on at `now`, microseconds. Call it whenever narx_master_poll_frame has returned NARX_NOTHING; until
/// its end the identification owns the requests, jobs and downloads of the master. Returns NARX_NOTHING
/// before the end and after it; at the end, once, NARX_OK with the figures, or the error. Then the motor
/// stands, and the drive has its former parameters, if it still answers. Errors of the motor and its supply:
/// NARX_ERROR_NO_MOTOR, NARX_ERROR_SHORT, NARX_ERROR_SAGS, NARX_ERROR_UNSTEADY, NARX_ERROR_NO_BACK_EMF,
/// NARX_ERROR_NOT_REACHED, NARX_ERROR_NO_ROOM, NARX_ERROR_COMMISSIONING; of the drive: NARX_ERROR_WRONG_STATE
/// outside Standby, NARX_ERROR_NOT_EQUIPPED without a scope, NARX_ERROR_BOARD for its PWM rate, those of
/// narx_master_poll_job, of an answer and of a download.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_identification_step(
    identification: *mut narx_identification_t,
    master: *mut narx_master_t,
    now: u64,
    identified: *mut narx_identified_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        let WithError { identification, error } = handle::object(identification)?;
        let master = handle::object(master)?;
        pointer::check(identified)?;
        match identification.step(master, now).ok_or(NARX_NOTHING)? {
            Ok(found) => pointer::write(identified, found.into()),
            Err(reason) => {
                *error = Some(reason);
                Err(reason.into())
            }
        }
    };
    pointer::status(run())
}

/// Writes the part that is under way: a narx_identification_stage_t.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_identification_stage(
    identification: *mut narx_identification_t,
    stage: *mut u8,
) -> narx_status_t {
    use narx_identification_stage_t as Number;
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        let number = match handle::object(identification)?.identification.stage() {
            Stage::Asks => Number::Asks,
            Stage::Holds => Number::Holds,
            Stage::Counts => Number::Counts,
            Stage::Spins => Number::Spins,
            Stage::Accelerates => Number::Accelerates,
            Stage::Calibrates => Number::Calibrates,
            Stage::Restores => Number::Restores,
        };
        pointer::write(stage, number as u8)
    };
    pointer::status(run())
}

/// A mark on the shaft passes the same place as the last time, at `now`, microseconds: while the rotor turns
/// slowly, in the stage Counts, three of these tell the pole pairs. Returns NARX_ERROR_WRONG_STATE, and
/// nothing happens, at any other time.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_identification_mark(
    identification: *mut narx_identification_t,
    now: u64,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        let counts = handle::object(identification)?.identification.mark(now);
        counts.then_some(()).ok_or(NARX_ERROR_WRONG_STATE)
    };
    pointer::status(run())
}

/// Stops the motor and restores the parameters, in the steps that follow; the end is NARX_ERROR_ABORTED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_identification_abort(
    identification: *mut narx_identification_t,
    master: *mut narx_master_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        let identification = &mut handle::object(identification)?.identification;
        identification.abort(handle::object(master)?);
        Ok(())
    };
    pointer::status(run())
}

/// Writes in words with which error the identification has ended, with its figures; returns NARX_NOTHING if
/// it has ended with none. The text, at most `size` bytes with its closing 0, is cut if it is longer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_identification_error_text(
    identification: *mut narx_identification_t,
    text: *mut c_char,
    size: usize,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        let error = handle::object(identification)?.error.ok_or(NARX_NOTHING)?;
        text::write(text, size, error)
    };
    pointer::status(run())
}

impl From<Figure> for narx_figure_t {
    fn from(Figure { value, uncertainty }: Figure) -> Self {
        Self { value, uncertainty }
    }
}

impl From<Identified> for narx_identified_t {
    fn from(found: Identified) -> Self {
        let turned = found.turned.unwrap_or_default();
        let halls = found.halls.unwrap_or_default();
        Self {
            temperature: found.temperature.unwrap_or(f64::NAN),
            supply: found.supply,
            current: found.current,
            resistance: found.resistance.into(),
            inductance: found.inductance.into(),
            torque_constant: turned.torque_constant.into(),
            inertia: turned.inertia.into(),
            friction: turned.friction.into(),
            static_friction: turned.static_friction,
            viscous_friction: turned.viscous_friction,
            speed: turned.speed,
            pole_pairs: found.pole_pairs,
            turned: found.turned.is_some().into(),
            calibrated: found.halls.is_some().into(),
            hall_order: halls.order,
            hall_polarity: halls.polarity,
            hall_offset: halls.offset,
        }
    }
}

impl From<IdentificationError> for narx_status_t {
    fn from(error: IdentificationError) -> Self {
        use IdentificationError as Error;
        match error {
            Error::PolePairs(_) | Error::Current(_) | Error::Bridge(_) | Error::Held => NARX_ERROR_ARGUMENT,
            Error::Rate(_) => NARX_ERROR_BOARD,
            Error::Value(_) => NARX_ERROR_OUT_OF_RANGE,
            Error::NotInStandby(_) => NARX_ERROR_WRONG_STATE,
            Error::Lost | Error::Request(_, RequestError::NoAnswer) => NARX_ERROR_NO_ANSWER,
            Error::NoScope { .. } => NARX_ERROR_NOT_EQUIPPED,
            Error::NoMotor { .. } => NARX_ERROR_NO_MOTOR,
            Error::Short { .. } => NARX_ERROR_SHORT,
            Error::Sags { .. } => NARX_ERROR_SAGS,
            Error::Unsteady(_) | Error::NotCounted { .. } => NARX_ERROR_UNSTEADY,
            Error::NoBackEmf { .. } => NARX_ERROR_NO_BACK_EMF,
            Error::NotReached { .. } => NARX_ERROR_NOT_REACHED,
            Error::NoRoom { .. } => NARX_ERROR_NO_ROOM,
            Error::Commissioning(_) => NARX_ERROR_COMMISSIONING,
            Error::Job(error) => error.into(),
            Error::Request(_, RequestError::NotObeyed) => NARX_ERROR_NOT_OBEYED,
            Error::Request(_, RequestError::Refused(refusal)) => refusal.status.into(),
            Error::Download(error) => error.into(),
            Error::NotTaken(reason) => reason.into(),
            Error::Aborted => NARX_ERROR_ABORTED,
        }
    }
}
