//! Hall sensors.

use super::{Column, numbers, reals, same_length};
use crate::coefficients::constant;
use crate::error::{self, Given};
use narx_core::blocks::engineering::{HALL_OFFSET, HALL_TIMEOUT, degrees, instant, raw, real};
use narx_core::blocks::{Hall as Core, HallReading as Reading, HallSettings};
use narx_core::motor::{Edge, EdgeSource};
use narx_core::units::ElectricalSpeed;
use numpy::{AllowTypeChange, IntoPyArray, PyArrayLike1};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Hall sensors: sector, electrical angle and speed from codes and time-stamped edges.
///
/// A neighbouring code after a plausible interval is accepted at once, any other change only if it is still
/// there a tick later. The speed is taken over up to a revolution (valid / 6 turns over the sum of the last
/// intervals); the angle is interpolated with it. It is the drive's hall station
/// (`narx_core::motor::rotor::hall`), bit for bit.
///
/// tick_rate: 1 000 to 100 000 Hz. order: permutation of the lines, 0 to 5 (parameter 262). polarity: lines
/// to invert, 0 to 7 (parameter 263). offset: offset of the edges beyond their place, -180 to 180 electrical
/// degrees (parameter 80). timeout: no edge for this long is standstill, s (parameter 113), at most
/// 65 535 ticks. interpolation_min: slowest electrical speed that is interpolated, rev/s. captured: edges are
/// time-stamped, else only the level is read. Raises ParameterError, which names the argument that is out of
/// range.
#[pyclass(module = "narx.blocks")]
pub(crate) struct Hall {
    core: Core,
    tick_rate: u32,
}

/// Reading of the hall sensors after a tick.
#[pyclass(module = "narx.blocks", frozen, get_all)]
pub(crate) struct HallReading {
    /// Sector, 0 to 5: sector s spans 30 + 60 s to 90 + 60 s degrees; `None` until the first valid code.
    sector: Option<u8>,
    /// Electrical angle, degrees, 0 to 360.
    angle: f64,
    /// Electrical speed, rev/s, negative in reverse, limited by the time for which the next edge has not
    /// come.
    speed: f64,
    /// Sectors turned in this tick, signed.
    sectors: i8,
    /// The code is 000 or 111.
    invalid: bool,
    /// A sector was skipped.
    jump: bool,
    /// No edge for the time-out: standstill.
    stopped: bool,
    /// The position is doubtful: torque by it could act in any direction.
    doubtful: bool,
}

#[pymethods]
impl Hall {
    #[new]
    #[pyo3(signature = (tick_rate=Given::Whole(10_000), order=Given::Whole(0), polarity=Given::Whole(0), offset=Given::Real(0.0),
                        timeout=Given::Real(0.1), interpolation_min=Given::Real(1.0), captured=false),
           text_signature = "(tick_rate=10000, order=0, polarity=0, offset=0.0, timeout=0.1, interpolation_min=1.0, captured=False)")]
    fn new(
        tick_rate: Given,
        order: Given,
        polarity: Given,
        offset: Given,
        timeout: Given,
        interpolation_min: Given,
        captured: bool,
    ) -> PyResult<Self> {
        let [offset, timeout, interpolation_min] =
            reals([("offset", offset), ("timeout", timeout), ("interpolation_min", interpolation_min)])?;
        let tick_rate = error::whole("tick_rate", tick_rate, "Hz", 0, u32::MAX)?;
        let order = error::whole("order", order, "", 0, 5)?;
        let polarity = error::whole("polarity", polarity, "", 0, 7)?;
        let core = numbers(|| {
            let floor = raw("interpolation_min", interpolation_min, "rev/s")?;
            Ok(Core::build(&HallSettings {
                tick_rate,
                offset_cdeg: HALL_OFFSET.setting("offset", offset)?,
                timeout_ms: HALL_TIMEOUT.setting("timeout", timeout)?,
                interpolation_min: ElectricalSpeed::from_bits(floor),
                order,
                polarity,
                captured,
            })?)
        })?;
        Ok(Self { core, tick_rate })
    }

    /// Returns the coefficients as the definition of a C99 constant, for `narx_hall_init_ready`.
    ///
    /// Raises ParameterError for a name that is none in C.
    #[pyo3(signature = (name="hall"))]
    fn to_c(&self, name: &str) -> PyResult<String> {
        constant("narx_hall_ready_t", name, self.core.ready())
    }

    /// Runs one tick. code: the lines now, bit 0 = A, bit 1 = B, bit 2 = C. edges: those of the period that
    /// has ended, oldest first, each (instant in periods, code after it); only the first four count.
    #[pyo3(signature = (code, edges=None))]
    fn step(&mut self, code: Given, edges: Option<Vec<(f64, u8)>>) -> PyResult<HallReading> {
        let code = error::whole("code", code, "", 0, 7)?;
        let edges: PyResult<Vec<Edge>> = edges
            .unwrap_or_default()
            .into_iter()
            .map(|(at, code)| Ok(edge(instant("edge", at).map_err(error::parameter)?, code)))
            .collect();
        Ok(reading(&self.core.step(code, &edges?)))
    }

    /// Runs a tick for each code; returns "sector" (255 unknown), "angle" (electrical degrees), "speed"
    /// (electrical rev/s), "stopped" and "doubtful", arrays of shape (n,). code: shape (n,). edge_time,
    /// edge_code: of captured edges, in order, shape (m,); s since the first code was read, which ends period
    /// 0.
    #[pyo3(signature = (code, edge_time=None, edge_code=None))]
    fn run<'py>(
        &mut self,
        py: Python<'py>,
        code: PyArrayLike1<'py, u8, AllowTypeChange>,
        edge_time: Option<Column<'py>>,
        edge_code: Option<PyArrayLike1<'py, u8, AllowTypeChange>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let edges = self.edges(edge_time.as_ref(), edge_code.as_ref())?;
        let mut edges = edges.into_iter().peekable();
        let readings: Vec<Reading> = code
            .as_array()
            .iter()
            .enumerate()
            .map(|(tick, code)| {
                let mut passed = Vec::new();
                while let Some((_, edge)) = edges.next_if(|(period, _)| *period <= tick as i64) {
                    passed.push(edge);
                }
                self.core.step(*code, &passed)
            })
            .collect();
        let columns = PyDict::new(py);
        let sector: Vec<u8> = readings.iter().map(|reading| reading.sector.unwrap_or(255)).collect();
        columns.set_item("sector", sector.into_pyarray(py))?;
        let angle: Vec<f64> = readings.iter().map(|reading| degrees(reading.position.angle)).collect();
        columns.set_item("angle", angle.into_pyarray(py))?;
        let speed: Vec<f64> = readings.iter().map(|reading| real(reading.speed.to_bits())).collect();
        columns.set_item("speed", speed.into_pyarray(py))?;
        let stopped: Vec<bool> = readings.iter().map(|reading| reading.stopped).collect();
        columns.set_item("stopped", stopped.into_pyarray(py))?;
        let doubtful: Vec<bool> = readings.iter().map(|reading| reading.doubtful).collect();
        columns.set_item("doubtful", doubtful.into_pyarray(py))?;
        Ok(columns)
    }

    /// Number of invalid codes (000 or 111), and of skipped sectors, since the object was made.
    #[getter]
    fn glitches(&self) -> (u16, u16) {
        let counts = self.core.diagnostics();
        (counts.invalid, counts.jumps)
    }
}

impl Hall {
    /// Assigns each edge to the tick that ends its period.
    fn edges(
        &self,
        time: Option<&Column<'_>>,
        code: Option<&PyArrayLike1<'_, u8, AllowTypeChange>>,
    ) -> PyResult<Vec<(i64, Edge)>> {
        let (Some(time), Some(code)) = (time, code) else {
            return match (time, code) {
                (None, None) => Ok(Vec::new()),
                _ => Err(error::parameter("edge_time and edge_code: one without the other")),
            };
        };
        let (time, code) = (time.as_array(), code.as_array());
        same_length("edge_code", code.len(), "edge_time", time.len())?;
        let mut edges: Vec<(i64, Edge)> = Vec::with_capacity(time.len());
        let mut before = f64::NEG_INFINITY;
        for (row, (time, code)) in time.iter().zip(&code).enumerate() {
            let name = format!("edge_time[{row}]");
            let allowed = "a finite number, not before the last one";
            error::number(&name, *time, "s", allowed, |time| time >= before)?;
            before = *time;
            let periods = *time * f64::from(self.tick_rate);
            let period = periods.floor();
            let instant = ((periods - period) * 65_536.0).min(65_535.0) as u16;
            edges.push((period as i64 + 1, edge(instant, *code)));
        }
        Ok(edges)
    }
}

fn edge(instant: u16, code: u8) -> Edge {
    Edge { instant, source: EdgeSource::Hall, code: code & 7 }
}

fn reading(reading: &Reading) -> HallReading {
    HallReading {
        sector: reading.sector,
        angle: degrees(reading.position.angle),
        speed: real(reading.speed.to_bits()),
        sectors: reading.events.sectors,
        invalid: reading.events.invalid,
        jump: reading.events.jump,
        stopped: reading.stopped,
        doubtful: reading.doubtful,
    }
}
