//! Tests of steady states that follow from the data alone.

use crate::driving::Ideal;
use narx_sim::plant::{BackEmf, MotorConfig, Plant, PlantConfig};

#[test]
fn no_load_speed_at_full_duty_is_the_supply_over_the_torque_constant() {
    for back_emf in [BackEmf::Trapezoidal { flat_top_deg: 120.0 }, BackEmf::Sinusoidal] {
        let motor = MotorConfig { back_emf, ..MotorConfig::default() };
        let mut config = PlantConfig::new(motor, 24.0);
        // With a source that cannot sink, the ripple would raise the bus a little above 24 V.
        config.supply.may_sink = true;
        let mut plant = Plant::new(&config);
        Ideal::forward(1.0).run(&mut plant, 1.0);
        let seen = plant.observe();
        let expected = 24.0 / 0.036;
        assert!((seen.speed / expected - 1.0).abs() < 0.01, "{} rad/s, expected {expected}", seen.speed);
    }
}
