//! Zero crossings.

use super::{Column, direction, numbers, reals, same_length, step};
use crate::coefficients::constant;
use crate::error::{self, Given};
use crate::state::words;
use narx_core::blocks::engineering::{
    ADVANCE, BACK_EMF, BLANKING, Scale, VOLTS_PER_CODE, degrees, instant, real, turn,
};
use narx_core::blocks::{
    CommutationSettings, ZeroCrossing as Core, ZeroCrossingReading as Reading, ZeroCrossingSettings,
};
use narx_core::motor::commutate::pwm::Commutation;
use narx_core::motor::guard::rails::Rail;
use narx_core::motor::sense::front_end::Channel;
use narx_core::motor::{PwmCommand, SampleMode, Samples};
use numpy::{AllowTypeChange, IntoPyArray, PyArrayLike1, PyArrayLike2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Zero crossings of the back-EMF: crossing, electrical angle, speed and next commutation from the terminal
/// voltages of a driven or coasting motor.
///
/// The floating terminal is compared with the mean of the other two; the crossing lies where 2 v_f - v_g -
/// v_h passes 0, interpolated between samples. Crossings are the middles of the sectors (60 + 60 s degrees);
/// the commutation lies 30 degrees less the advance behind. They are the drive's stations
/// (`narx_core::motor::rotor::back_emf`, `zero_crossing`, `listening`), bit for bit, but without its start
/// sequence: align the rotor, call `start`, and commutate at the instants of the readings.
///
/// tick_rate: 1 000 to 100 000 Hz. volts_per_code: of the converter to which the voltages are rounded, up to
/// 0.0625 V. noise_codes: smallest signal, 1 to 255 codes. blanking: least time after a commutation, s
/// (parameter 86). advance: 0 to 30 electrical degrees. earliest: instant of the period at which a step acts,
/// periods. back_emf: line to line, V a mechanical rpm (parameter 267); 0 unknown. pole_pairs: 1 to 100.
/// timeout: no crossing for this long is standstill, s. Raises ParameterError, which names the argument that
/// is out of range.
#[pyclass(module = "narx.blocks")]
pub(crate) struct ZeroCrossing {
    core: Core,
    volts_per_code: f64,
    tick_rate: f64,
}

/// Reading of the terminals after a tick.
#[pyclass(module = "narx.blocks", frozen, get_all)]
pub(crate) struct ZeroCrossingReading {
    /// Age of a crossing that was seen in this tick: time from it to the present boundary, s (negative is
    /// after the boundary); else `None`.
    crossing: Option<f64>,
    /// Outcome of the last step's crossing: "none", "accepted", "filtered", "blind", "demag_late" or
    /// "listened".
    why: String,
    /// Lag of the last accepted crossing behind its prediction, electrical degrees.
    margin: f64,
    /// Number of accepted crossings.
    accepted: u32,
    /// Electrical angle, degrees, 0 to 360.
    angle: f64,
    /// Electrical speed, rev/s, negative in reverse; 0 while unknown.
    speed: f64,
    /// Time from the present boundary to the next commutation, s; 0 is now, `None` is unknown.
    commutation: Option<f64>,
    /// Six consistent crossings were seen: the loop may be closed.
    running: bool,
    /// Reason why the rotor was lost in this tick: "stall" or "desynchronised"; else `None`.
    lost: Option<String>,
}

#[pymethods]
impl ZeroCrossing {
    #[new]
    #[pyo3(signature = (tick_rate=Given::Whole(10_000), volts_per_code=Given::Real(0.019_531), noise_codes=Given::Whole(4),
                        blanking=Given::Real(200e-6), advance=Given::Real(0.0), earliest=Given::Real(0.125),
                        back_emf=Given::Real(0.0), pole_pairs=Given::Whole(1), timeout=Given::Real(0.05)),
           text_signature = "(tick_rate=10000, volts_per_code=0.019531, noise_codes=4, blanking=0.0002, advance=0.0, \
                             earliest=0.125, back_emf=0.0, pole_pairs=1, timeout=0.05)")]
    #[allow(clippy::too_many_arguments, reason = "Python calls it with names")]
    fn new(
        tick_rate: Given,
        volts_per_code: Given,
        noise_codes: Given,
        blanking: Given,
        advance: Given,
        earliest: Given,
        back_emf: Given,
        pole_pairs: Given,
        timeout: Given,
    ) -> PyResult<Self> {
        let [volts_per_code, blanking, advance, earliest, back_emf, timeout] = reals([
            ("volts_per_code", volts_per_code),
            ("blanking", blanking),
            ("advance", advance),
            ("earliest", earliest),
            ("back_emf", back_emf),
            ("timeout", timeout),
        ])?;
        let tick_rate: u32 = error::whole("tick_rate", tick_rate, "Hz", 0, u32::MAX)?;
        let noise_codes = error::whole("noise_codes", noise_codes, "", 0, u8::MAX)?;
        let pole_pairs = error::whole("pole_pairs", pole_pairs, "", 0, u16::MAX)?;
        numbers(|| {
            let micro_per_code = VOLTS_PER_CODE.setting("volts_per_code", volts_per_code)?;
            let channel = Channel { zero: 0, micro_per_code };
            let core = Core::build(&ZeroCrossingSettings {
                tick_rate,
                blanking_us: BLANKING.setting("blanking", blanking)?,
                back_emf_uv_per_rpm: BACK_EMF.setting("back_emf", back_emf)?,
                terminal: channel,
                bus_voltage: channel,
                commutation: CommutationSettings {
                    advance_cdeg: ADVANCE.setting("advance", advance)?,
                    earliest: instant("earliest", earliest)?,
                },
                pole_pairs,
                timeout_ticks: Scale::zero_crossing_timeout(tick_rate.into()).setting("timeout", timeout)?,
                noise_codes,
                ..ZeroCrossingSettings::default()
            })?;
            Ok(Self { core, volts_per_code: f64::from(micro_per_code) / 1e6, tick_rate: tick_rate.into() })
        })
    }

    /// Begins to bring up a rotor that rests at `angle`, electrical degrees.
    #[pyo3(signature = (angle, reverse=false))]
    fn start(&mut self, angle: Given, reverse: bool) -> PyResult<()> {
        let [angle] = reals([("angle", angle)])?;
        numbers(|| turn("angle", angle).map(|turn| self.core.start(turn, direction(reverse))))
    }

    /// Goes on by a step without any evidence: the rotor that is being brought up has not moved.
    fn force_step(&mut self) {
        self.core.force_step();
    }

    /// Returns the coefficients as the definition of a C99 constant, for `narx_zero_crossing_init_ready`.
    ///
    /// Raises ParameterError for a name that is none in C.
    #[pyo3(signature = (name="zero_crossing"))]
    fn to_c(&self, name: &str) -> PyResult<String> {
        constant("narx_zero_crossing_ready_t", name, self.core.ready())
    }

    /// Runs one tick. phase_voltage: terminals A, B, C against ground, V. bus_voltage: V. step: the pattern
    /// that was in force in the period that has ended (`Step`), and its changes in that period as (instant in
    /// periods, step). on_time: sampled in the on-time, else in the off-time. sample_at: instant of the
    /// sample, periods. reverse: torque in reverse.
    #[pyo3(signature = (phase_voltage, bus_voltage, step, changes=None, on_time=true, sample_at=Given::Real(0.0), reverse=false),
           text_signature = "($self, phase_voltage, bus_voltage, step, changes=None, on_time=True, sample_at=0.0, reverse=False)")]
    #[allow(clippy::too_many_arguments, reason = "Python calls it with names")]
    fn step(
        &mut self,
        phase_voltage: [f64; 3],
        bus_voltage: Given,
        step: Given,
        changes: Option<Vec<(f64, u8)>>,
        on_time: bool,
        sample_at: Given,
        reverse: bool,
    ) -> PyResult<ZeroCrossingReading> {
        let bus_voltage = error::finite("bus_voltage", bus_voltage, "V")?;
        let [sample_at] = reals([("sample_at", sample_at)])?;
        let mut applied = self.applied(step, on_time)?;
        applied.sample_at = instant("sample_at", sample_at).map_err(error::parameter)?;
        for (at, step) in changes.unwrap_or_default() {
            let instant = instant("change", at).map_err(error::parameter)?;
            applied.commutations.push(Commutation { instant, step: self::step(step)? });
        }
        let samples = self.samples("phase_voltage", phase_voltage, bus_voltage, on_time)?;
        let reading = self.core.step(&samples, &applied, direction(reverse));
        Ok(self.reading(&reading))
    }

    /// Runs a tick for each row; returns "crossing" (s before the boundary, NaN without one), "angle"
    /// (electrical degrees), "speed" (electrical rev/s), "commutation" (s, NaN unknown) and "running", arrays
    /// of shape (n,). phase_voltage: shape (n, 3), V. bus_voltage: shape (n,), V. step: shape (n,), the
    /// pattern in force before each sample.
    #[pyo3(signature = (phase_voltage, bus_voltage, step, on_time=true, reverse=false))]
    fn run<'py>(
        &mut self,
        py: Python<'py>,
        phase_voltage: PyArrayLike2<'py, f64, AllowTypeChange>,
        bus_voltage: Column<'py>,
        step: PyArrayLike1<'py, u8, AllowTypeChange>,
        on_time: bool,
        reverse: bool,
    ) -> PyResult<Bound<'py, PyDict>> {
        let (phases, bus, step) = (phase_voltage.as_array(), bus_voltage.as_array(), step.as_array());
        if phases.ncols() != 3 {
            let columns = phases.ncols();
            return Err(error::parameter(format!("phase_voltage of {columns} columns: must have 3")));
        }
        same_length("bus_voltage", bus.len(), "phase_voltage", phases.nrows())?;
        same_length("step", step.len(), "phase_voltage", phases.nrows())?;
        let mut readings = Vec::with_capacity(phases.nrows());
        for (row, ((phases, bus), step)) in phases.rows().into_iter().zip(&bus).zip(&step).enumerate() {
            let applied = self.applied(*step, on_time)?;
            let volts = [phases[0], phases[1], phases[2]];
            let samples = self.samples(&format!("phase_voltage[{row}]"), volts, *bus, on_time)?;
            let reading = self.core.step(&samples, &applied, direction(reverse));
            readings.push(self.reading(&reading));
        }
        let columns = PyDict::new(py);
        let column = |of: fn(&ZeroCrossingReading) -> f64| {
            readings.iter().map(of).collect::<Vec<f64>>().into_pyarray(py)
        };
        columns.set_item("crossing", column(|reading| reading.crossing.unwrap_or(f64::NAN)))?;
        columns.set_item("angle", column(|reading| reading.angle))?;
        columns.set_item("speed", column(|reading| reading.speed))?;
        columns.set_item("commutation", column(|reading| reading.commutation.unwrap_or(f64::NAN)))?;
        let running: Vec<bool> = readings.iter().map(|reading| reading.running).collect();
        columns.set_item("running", running.into_pyarray(py))?;
        Ok(columns)
    }
}

impl ZeroCrossing {
    fn applied(&self, step: impl Into<Given>, on_time: bool) -> PyResult<PwmCommand> {
        Ok(PwmCommand { step: self::step(step)?, sample_mode: mode(on_time), ..PwmCommand::default() })
    }

    fn samples(&self, name: &str, phases: [f64; 3], bus: f64, on_time: bool) -> PyResult<Samples> {
        let code = |name: &str, volts: f64| {
            let volts = error::finite(name, volts, "V")?;
            PyResult::Ok((volts / self.volts_per_code).round().clamp(0.0, 65_535.0) as u16)
        };
        let [a, b, c] = phases;
        Ok(Samples {
            phase_voltage: [code(name, a)?, code(name, b)?, code(name, c)?],
            bus_voltage: code("bus_voltage", bus)?,
            sample_mode: mode(on_time),
            ..Samples::default()
        })
    }

    fn reading(&self, reading: &Reading) -> ZeroCrossingReading {
        let seconds = |age: f64| age / 65_536.0 / self.tick_rate;
        ZeroCrossingReading {
            crossing: reading.crossing.map(|age| seconds(age.into())),
            why: words(&reading.why),
            margin: f64::from(reading.margin) * 360.0 / 65_536.0,
            accepted: reading.accepted,
            angle: degrees(reading.position.angle),
            speed: real(reading.speed.to_bits()),
            commutation: reading.commutation.map(|time| seconds(time.into())),
            running: reading.running,
            lost: (reading.lost != Rail::None).then(|| words(&reading.lost)),
        }
    }
}

const fn mode(on_time: bool) -> SampleMode {
    if on_time { SampleMode::OnTime } else { SampleMode::OffTime }
}
