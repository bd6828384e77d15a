//! Tests of the energy balance: the source's energy is lost, delivered or stored, to 0.1 %.

use crate::driving::Ideal;
use narx_core::motor::{Direction, PwmCommand, Rectification, Step};
use narx_sim::plant::{BackEmf, Injection, LoadConfig, MotorConfig, Phase, Plant, PlantConfig, SupplyConfig};
use proptest::prelude::*;

/// One stretch of driving.
#[derive(Clone, Copy, Debug)]
enum Stretch {
    /// Ideal commutation.
    Commutated { duty: f64, forward: bool, synchronous: bool },
    /// A fault begins or ends; the bridge goes on as before.
    Broken { what: Injection, active: bool },
    /// Any step, held.
    Held { step: usize, duty: f64, synchronous: bool },
}

fn stretch() -> impl Strategy<Value = Stretch> {
    prop_oneof![
        (0.0..=1.0f64, any::<bool>(), any::<bool>())
            .prop_map(|(duty, forward, synchronous)| Stretch::Commutated { duty, forward, synchronous }),
        (injection(), any::<bool>()).prop_map(|(what, active)| Stretch::Broken { what, active }),
        (0usize..13, 0.0..=0.3f64, any::<bool>()).prop_map(|(step, duty, synchronous)| Stretch::Held {
            step,
            duty,
            synchronous
        }),
    ]
}

fn injection() -> impl Strategy<Value = Injection> {
    let phase = prop_oneof![Just(Phase::A), Just(Phase::B), Just(Phase::C)];
    prop_oneof![
        phase.clone().prop_map(Injection::OpenPhase),
        phase.prop_map(Injection::Driver),
        (0.5..100.0f64).prop_map(Injection::Leak),
        Just(Injection::BlockedRotor),
        (5.0..70.0f64).prop_map(Injection::Supply),
        (-40.0..200.0f64).prop_map(Injection::Ambient),
    ]
}

fn config() -> impl Strategy<Value = PlantConfig> {
    let electric = (0.2..2.0f64, 1e-4..2e-3f64, 0.02..0.1f64, 18.0..60.0f64, 0.0..0.3f64, any::<bool>());
    let shaft = (2e-6..2e-4f64, 0.0..0.01f64, 0.0..1e-5f64, 0.0..0.01f64);
    let shape = prop_oneof![
        Just(BackEmf::Sinusoidal),
        (60.0..150.0f64).prop_map(|flat_top_deg| BackEmf::Trapezoidal { flat_top_deg })
    ];
    let load = (0.0..0.02f64, 0.0..1e-5f64, 0.0..1e-7f64, -0.01..0.01f64);
    (electric, shaft, shape, load, 1u8..=8, 0.0..360.0f64).prop_map(
        |(electric, shaft, back_emf, load, pole_pairs, angle_deg)| {
            let (resistance, inductance, torque_constant, voltage, source, may_sink) = electric;
            let (inertia, static_friction, viscous_friction, cogging_torque) = shaft;
            let motor = MotorConfig {
                pole_pairs,
                resistance,
                inductance,
                torque_constant,
                inertia,
                static_friction,
                viscous_friction,
                back_emf,
                cogging_torque,
                ..MotorConfig::default()
            };
            let mut config = PlantConfig::new(motor, voltage);
            config.supply = SupplyConfig { voltage, resistance: source, may_sink };
            let (constant, viscous, quadratic, machine) = load;
            config.load = LoadConfig { constant, viscous, quadratic, machine, inertia: 0.0 };
            config.angle_deg = angle_deg;
            config
        },
    )
}

fn drive(plant: &mut Plant, stretch: Stretch, seconds: f64) {
    let rectification =
        |synchronous| if synchronous { Rectification::Synchronous } else { Rectification::Diode };
    match stretch {
        Stretch::Commutated { duty, forward, synchronous } => {
            let direction = if forward { Direction::Forward } else { Direction::Reverse };
            Ideal { duty, direction, rectification: rectification(synchronous) }.run(plant, seconds);
        }
        Stretch::Broken { what, active } => {
            if active {
                plant.inject(what);
            } else {
                plant.clear_all();
            }
            Ideal::forward(0.5).run(plant, seconds);
        }
        Stretch::Held { step, duty, synchronous } => {
            let ideal =
                Ideal { duty, direction: Direction::Forward, rectification: rectification(synchronous) };
            let command: PwmCommand = ideal.hold(Step::ALL[step]);
            for _ in 0..(seconds * 10_000.0) as u32 {
                plant.sample();
                plant.finish_period(&command);
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 250, ..ProptestConfig::default() })]

    #[test]
    fn energy_is_conserved_whatever_is_commanded(
        config in config(),
        stretches in prop::collection::vec(stretch(), 1..7),
    ) {
        let mut plant = Plant::new(&config);
        for stretch in stretches {
            drive(&mut plant, stretch, 0.05);
            let seen = plant.observe();
            let ledger = seen.ledger;
            let sum: f64 = seen.current.iter().sum();
            prop_assert!(sum.abs() < 1e-9, "currents sum to {sum}");
            prop_assert!(seen.bus_voltage.is_finite() && seen.speed.is_finite());
            let ratio = ledger.residual().abs() / ledger.turnover().max(1e-3);
            prop_assert!(ratio < 1e-3, "{ratio:.2e}: {ledger:?}");
        }
    }
}

/// Largest change of the balance in one period, J, while the rotor swings about the angle where a step holds
/// it, driven back to rest and beyond.
fn unbalanced(back_emf: BackEmf) -> f64 {
    let motor = MotorConfig {
        pole_pairs: 1,
        resistance: 0.2,
        inductance: 1.5e-3,
        torque_constant: 0.092,
        inertia: 2.4e-5,
        static_friction: 2.6e-3,
        viscous_friction: 8e-6,
        back_emf,
        ..MotorConfig::default()
    };
    let mut config = PlantConfig::new(motor, 18.0);
    config.load = LoadConfig { constant: 0.009, ..LoadConfig::default() };
    let mut plant = Plant::new(&config);
    Ideal::forward(0.5).run(&mut plant, 0.05);
    let braking = Ideal { duty: 0.7, direction: Direction::Reverse, rectification: Rectification::Diode };
    let mut most = 0.0_f64;
    let mut before = plant.observe().ledger.residual();
    for _ in 0..500 {
        braking.run(&mut plant, 1e-4);
        let residual = plant.observe().ledger.residual();
        most = most.max((residual - before).abs());
        before = residual;
    }
    most
}

#[test]
fn energy_is_conserved_where_a_rotor_turns_back() {
    let flat_tops = [146.0, 120.0, 100.0, 60.0].map(|flat_top_deg| BackEmf::Trapezoidal { flat_top_deg });
    for back_emf in flat_tops.into_iter().chain([BackEmf::Sinusoidal]) {
        let most = unbalanced(back_emf);
        assert!(most < 5e-5, "{back_emf:?}: {most:.1e} J in a period");
    }
}
