//! The grids, and the plant of a cell.

use narx_core::commissioning::{Mode, Nameplate};
use narx_core::motor::Board;
use narx_sim::plant::{LoadConfig, MotorConfig, PlantConfig};
use narx_sim::presets::Preset;
use narx_sim::random_plant::{RandomPlant, lock_torque};

/// One start: its deviations from the data sheet.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    preset: &'static Preset,
    /// Inertia, times the data sheet's.
    inertia: f64,
    /// Coulomb friction, times the data sheet's.
    friction: f64,
    /// Share of the lock's torque that friction and load take together, with the load a Coulomb torque;
    /// without a share there is no load.
    load: Option<f64>,
    /// Supply voltage, V.
    supply: f64,
    /// Temperature of winding and magnets, degrees Celsius.
    temperature: f64,
    /// Electrical angle of the rotor, degrees.
    angle: f64,
    reverse: bool,
    /// Position in its grid.
    pub(super) column: usize,
    pub(super) row: usize,
}

/// An axis: a factor, its values, and the function that sets it.
pub(super) struct Axis {
    pub(super) title: &'static str,
    pub(super) values: &'static [f64],
    set: fn(&mut Cell, f64),
    /// Limits of the promise: values beyond are not promised.
    pub(super) promised: (f64, f64),
}

/// A grid of two factors.
pub(super) struct Grid {
    pub(super) x: &'static Axis,
    pub(super) y: &'static Axis,
}

const INERTIA: Axis = Axis {
    title: "inertia, times the data sheet's",
    values: &[0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0],
    set: |cell, value| cell.inertia = value,
    promised: (0.2, 5.0),
};
const LOAD: Axis = Axis {
    title: "friction and load, % of the lock's torque",
    values: &[0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 80.0, 100.0, 120.0],
    set: |cell, value| cell.load = Some(0.01 * value),
    promised: (0.0, 50.0),
};
const FRICTION: Axis = Axis {
    title: "Coulomb friction, times the data sheet's",
    values: &[0.0, 1.0, 2.0, 3.0, 5.0, 8.0, 12.0, 20.0],
    set: |cell, value| cell.friction = value,
    promised: (0.0, 3.0),
};
const SUPPLY: Axis = Axis {
    title: "supply, V",
    values: &[18.0, 24.0, 30.0, 36.0, 42.0, 48.0, 54.0, 60.0],
    set: |cell, value| cell.supply = value,
    promised: (18.0, 60.0),
};
const TEMPERATURE: Axis = Axis {
    title: "winding and magnets, \u{b0}C",
    values: &[-40.0, 0.0, 25.0, 60.0, 90.0, 120.0, 150.0, 190.0],
    set: |cell, value| cell.temperature = value,
    promised: (0.0, 190.0),
};
const ANGLE: Axis = Axis {
    title: "electrical angle of the rotor, degrees",
    values: &[0.0, 30.0, 60.0, 90.0, 120.0, 150.0, 180.0, 210.0, 240.0, 270.0, 300.0, 330.0],
    set: |cell, value| cell.angle = value,
    promised: (0.0, 360.0),
};

/// All grids: three, so that each factor is combined with the one that it is most likely to interact with.
pub(super) const GRIDS: [Grid; 3] =
    [Grid { x: &INERTIA, y: &LOAD }, Grid { x: &SUPPLY, y: &TEMPERATURE }, Grid { x: &ANGLE, y: &FRICTION }];

impl Grid {
    /// Cells of the grid for a motor, each in both directions.
    pub(super) fn cells(&self, preset: &'static Preset) -> impl Iterator<Item = Cell> {
        let middle = Cell {
            preset,
            inertia: 1.0,
            friction: 1.0,
            load: None,
            supply: preset.data.nominal_voltage.clamp(18.0, 60.0),
            temperature: 25.0,
            angle: 0.0,
            reverse: false,
            column: 0,
            row: 0,
        };
        let places = (0..self.x.values.len())
            .flat_map(|column| (0..self.y.values.len()).map(move |row| (column, row)));
        places.flat_map(move |(column, row)| {
            [false, true].map(|reverse| {
                // Angles that are special neither for the lock nor for the sensors; a grid of angles sets
                // its own.
                let angle = (77.0 + 137.5 * (column * self.y.values.len() + row) as f64).rem_euclid(360.0);
                let mut cell = Cell { reverse, column, row, angle, ..middle };
                for (axis, place) in [(self.x, column), (self.y, row)] {
                    if let Some(value) = axis.values.get(place) {
                        (axis.set)(&mut cell, *value);
                    }
                }
                cell
            })
        })
    }
}

impl Cell {
    /// Returns whether every factor but friction and load together is within the promise.
    pub(super) fn is_promised(&self) -> bool {
        let within = |axis: &Axis, value: f64| (axis.promised.0..=axis.promised.1).contains(&value);
        within(&INERTIA, self.inertia)
            && within(&FRICTION, self.friction)
            && within(&SUPPLY, self.supply)
            && within(&TEMPERATURE, self.temperature)
    }

    /// Plant of the cell with this board, commissioned from the data sheet, and the share of the lock's
    /// torque that friction and load take; nothing if commissioning refuses the motor at this supply.
    pub(super) fn plant(&self, board: &Board) -> Option<(RandomPlant, f64)> {
        let sheet = &self.preset.motor;
        let plate = Nameplate {
            motor: sheet.figures(),
            rated_current: self.preset.data.rated_current,
            supply: self.supply,
            open_loop_speed: None,
        };
        let commissioning = plate.commission_on(board, Mode::Sensorless, None).ok()?;
        let warmer = self.temperature - 25.0;
        let (resistance, back_emf) = (1.0 + sheet.copper_drift * warmer, 1.0 + sheet.magnet_drift * warmer);
        let motor = MotorConfig {
            inertia: sheet.inertia * self.inertia,
            static_friction: sheet.static_friction * self.friction,
            resistance: sheet.resistance * resistance,
            torque_constant: sheet.torque_constant * back_emf,
            ..*sheet
        };
        let lock = lock_torque(&commissioning, &motor, self.supply)?;
        let load = (self.load.unwrap_or(0.0) * lock - motor.static_friction).max(0.0);
        let breakaway = (motor.static_friction + load) / lock;
        let mut plant = PlantConfig { board: *board, ..PlantConfig::new(motor, self.supply) };
        plant.load = LoadConfig { constant: load, ..LoadConfig::default() };
        plant.angle_deg = self.angle;
        let rpm = (0.5 * (commissioning.speed_min + commissioning.speed_max)).ceil() as i32;
        let drawn = RandomPlant {
            preset: self.preset,
            inertia: self.inertia,
            friction: self.friction,
            resistance,
            back_emf,
            load: load / self.preset.rated_torque(),
            quadratic: false,
            rpm: if self.reverse { -rpm } else { rpm },
            plant,
            commissioning,
        };
        Some((drawn, breakaway))
    }
}
