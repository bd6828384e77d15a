//! Account of the energy: delivered, lost and stored.

/// Energies since the start, J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ledger {
    /// Delivered by the ideal source.
    pub source: f64,
    /// Lost in the source resistance.
    pub source_loss: f64,
    /// Taken by the drive's own electronics and an injected leak.
    pub leak: f64,
    /// Lost in the windings.
    pub copper: f64,
    /// Lost in on-resistances and diode slopes.
    pub switches: f64,
    /// Lost in diode drops.
    pub diodes: f64,
    /// Lost in the motor's Coulomb and viscous friction, and in an injected block.
    pub friction: f64,
    /// Taken by the load on the shaft; a machine that drives it gives energy, which counts as negative.
    pub load: f64,
    /// Lost where a cable broke under current.
    pub arc: f64,
    /// Electrical energy turned into mechanical energy (from one account above to another; not part of the
    /// sum).
    pub shaft: f64,
    /// Stored now, less stored at the start: bus capacitor, inductances, kinetic, cogging.
    pub stored: f64,
}

impl Ledger {
    /// Returns the energy that is unaccounted for, J; positive if energy vanished.
    pub fn residual(&self) -> f64 {
        self.source
            - (self.source_loss
                + self.leak
                + self.copper
                + self.switches
                + self.diodes
                + self.friction
                + self.load
                + self.arc
                + self.stored)
    }

    /// All energy that was moved, J: what the residual is to be compared with.
    pub fn turnover(&self) -> f64 {
        self.source.abs()
            + self.source_loss
            + self.leak
            + self.copper
            + self.switches
            + self.diodes
            + self.friction
            + self.load.abs()
            + self.arc
    }
}
