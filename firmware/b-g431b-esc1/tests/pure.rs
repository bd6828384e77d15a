//! Arithmetic of the board against its data sheets: tables that a reader can follow with a calculator.

use narx_b_g431b_esc1::analog::{self, FRONT_END, SHUNT_ZERO, terminal};
use narx_b_g431b_esc1::can::{BIT_RATE, BitTiming, CLOCK_HZ, bus_state, decode, encode};
use narx_b_g431b_esc1::edges::{Capture, Edges};
use narx_b_g431b_esc1::flash_map::{MAP, PAGE, SIZE, START};
use narx_b_g431b_esc1::pins::{Function, PINS, Port, words};
use narx_b_g431b_esc1::timing::{
    COMPARE_MAX, DEAD_TIME, PERIOD, TOP, compare, has_come, instant, part, position, sample_compare,
};
use narx_b_g431b_esc1::{BOARD, SKEW};
use narx_board::stm32::{Gates, dead_time_code, gates, pause, registers};
use narx_core::bus::{ErrorState, Frame, Id};
use narx_core::motor::{Edge, EdgeSource, Leg, Rectification, SampleMode, Samples, Step};
use narx_core::units::{Celsius, Duty, Volts};

fn degrees(value: Celsius) -> f64 {
    f64::from(value.to_bits()) / 65_536.0
}

fn volts(value: Volts) -> f64 {
    f64::from(value.to_bits()) / 65_536.0
}

#[test]
fn a_period_is_17000_counts_centred_on_the_boundary() {
    assert_eq!((PERIOD, TOP), (17_000, 8_500));
    // Duty in 1/32 768, compare value: the on-time is twice that, about the count 0.
    for (duty, value) in [(0, 0), (1, 0), (8_192, 2_125), (16_384, 4_250), (24_576, 6_375)] {
        assert_eq!(compare(Duty::from_bits(duty)), value, "duty {duty}");
    }
    // The low side charges the bootstrap capacitor for 2 us of every period, and two dead times surround
    // that.
    assert_eq!(compare(Duty::ONE), COMPARE_MAX);
    assert_eq!(u32::from(2 * (TOP - COMPARE_MAX)) * 1000 / 170, 3_600, "ns");
}

#[test]
fn instants_are_counts_and_counts_are_instants() {
    for (at, counts) in [(0, 0), (16_384, 4_250), (32_768, 8_500), (65_535, 16_999)] {
        assert_eq!(part(at), counts, "instant {at}");
    }
    for counts in 0..PERIOD {
        let there_and_back = i32::from(part(instant(counts)));
        assert!((there_and_back - i32::from(counts)).abs() <= 1, "{counts} counts");
    }
    assert_eq!(instant(PERIOD), u16::MAX);
    assert_eq!(
        [position(0, false), position(8_499, false), position(8_500, true), position(1, true)],
        [0, 8_499, 8_500, 16_999]
    );
    // The converter's trigger needs the counter to rise past its value.
    assert_eq!([sample_compare(0), sample_compare(9_175), sample_compare(u16::MAX)], [1, 2_379, TOP - 1]);
    assert!(has_come(0xFFF0, 0x0010) && has_come(5, 5) && !has_come(0x0010, 0xFFF0));
}

/// RM0440, TIM1_BDTR: what a code of the field DTG means, in clocks.
fn dead_time(code: u8) -> u16 {
    let code = u16::from(code);
    match code >> 5 {
        0..=3 => code,
        4 | 5 => (64 + (code & 0x3F)) * 2,
        6 => (32 + (code & 0x1F)) * 8,
        _ => (32 + (code & 0x1F)) * 16,
    }
}

#[test]
fn the_dead_time_is_never_shorter_than_asked_for() {
    assert_eq!(DEAD_TIME, 136, "800 ns of 170 MHz");
    assert_eq!(dead_time_code(DEAD_TIME), Some(0x84));
    for counts in 0..=1008 {
        let made = dead_time(dead_time_code(counts).expect("up to 1008"));
        assert!(made >= counts && made < counts + 16, "{counts} counts became {made}");
    }
    assert_eq!(dead_time_code(1009), None);
}

#[test]
fn every_step_is_its_legs_on_the_timer() {
    use Rectification::{Diode, Synchronous};
    // CCMR1 of A and B, CCMR2 of C: 68h PWM mode 1, 48h forced inactive, both preloaded. CCER: 5 both
    // outputs, 1 the high side's.
    let expected = [
        (Step::Coast, Synchronous, 0x4848, 0x48, 0x111),
        (Step::AB, Synchronous, 0x4868, 0x48, 0x155),
        (Step::AC, Synchronous, 0x4868, 0x48, 0x515),
        (Step::BC, Synchronous, 0x6848, 0x48, 0x551),
        (Step::BA, Synchronous, 0x6848, 0x48, 0x155),
        (Step::CA, Synchronous, 0x4848, 0x68, 0x515),
        (Step::CB, Synchronous, 0x4848, 0x68, 0x551),
        (Step::AB, Diode, 0x4868, 0x48, 0x151),
        (Step::CB, Diode, 0x4848, 0x68, 0x151),
        (Step::LockA, Synchronous, 0x4868, 0x48, 0x555),
        (Step::LockBC, Synchronous, 0x6848, 0x68, 0x555),
    ];
    for (step, rectification, ccmr1, ccmr2, ccer) in expected {
        let words = registers(gates(step, rectification));
        assert_eq!(
            (words.ccmr1, words.ccmr2, words.ccer),
            (ccmr1, ccmr2, ccer),
            "{step:?} {rectification:?}"
        );
    }
    for step in Step::ALL {
        for rectification in [Synchronous, Diode] {
            for (gates, leg) in gates(step, rectification).into_iter().zip(step.legs()) {
                let agrees = match leg {
                    Leg::Floating => gates == Gates::Off,
                    Leg::Low => gates == Gates::Low,
                    Leg::Switched => matches!(gates, Gates::Complementary | Gates::HighOnly),
                };
                assert!(agrees, "{step:?}: {leg:?} became {gates:?}");
            }
        }
    }
}

#[test]
fn no_leg_changes_sides_without_a_dead_time() {
    const ALL: [Gates; 4] = [Gates::Off, Gates::Low, Gates::Complementary, Gates::HighOnly];
    // The timer keeps the dead time between two states that both have both outputs enabled. A state that may
    // have the high side on, and one that has the low side on with the other output's enable different, need
    // a pause.
    let enabled_both = |gates: Gates| matches!(gates, Gates::Low | Gates::Complementary);
    for now in ALL {
        for next in ALL {
            let one_is_off = now == Gates::Off || next == Gates::Off;
            let needed = !one_is_off && enabled_both(now) != enabled_both(next);
            assert_eq!(now.needs_pause(next), needed, "{now:?} to {next:?}");
        }
    }
    let now = gates(Step::AB, Rectification::Diode);
    let next = gates(Step::BA, Rectification::Diode);
    assert_eq!(pause(now, next), Some([Gates::Off; 3]), "both legs change sides");
    let commutation = gates(Step::AC, Rectification::Diode);
    assert_eq!(pause(now, commutation), None, "A goes on, B is turned off, C was off");
}

#[test]
fn codes_are_volts_and_amperes_of_the_schematic() {
    const LSB: f64 = 3.3 / 4096.0;
    let micro = |channel: narx_core::motor::Channel| f64::from(channel.micro_per_code) * 1e-6;
    // 18 kohm of 187 at the bus, 2.2 of 12.2 at a terminal.
    let bus = LSB * 187.0 / 18.0;
    let phase = LSB * 12.2 / 2.2;
    assert!((micro(FRONT_END.bus_voltage) / bus - 1.0).abs() < 1e-4, "{bus} V a code");
    assert_eq!(FRONT_END.phase_voltage, FRONT_END.bus_voltage, "one scale for all voltages");
    for code in (0..4090).step_by(10) {
        let said =
            f64::from(terminal(code, Gates::Off, SampleMode::OffTime, 0)) * micro(FRONT_END.phase_voltage);
        let is = f64::from(code) * phase;
        assert!((said - is).abs() < 0.01, "code {code}: {is} V, said {said}");
    }
    // 3 milliohm, 0.571 of the network, 16 of the amplifier: 0.0274 V an ampere. A, B, C low in turn, half
    // duty.
    let per_ampere = 0.003 * 0.571 * 16.0 / LSB;
    for (leg, step) in [(1, Step::AB), (2, Step::AC), (0, Step::BA)] {
        for amperes in [-6.0, -0.1, 0.0, 0.1, 1.0, 12.0] {
            let gates = gates(step, Rectification::Synchronous);
            // In the on-time the sample of the switched leg does not count.
            let mut shunts = gates.map(|gates| if gates == Gates::Complementary { 9999 } else { 0 });
            shunts[leg] = (amperes * per_ampere) as i32;
            let code = analog::bus_current(shunts, gates, Duty::from_bits(16_384), SampleMode::OnTime);
            let said =
                (f64::from(code) - f64::from(FRONT_END.bus_current.zero)) * micro(FRONT_END.bus_current);
            // Half duty, less 0.8 of 100 us; a current into the switched leg has as much more.
            let is = (0.5 - 0.008 * amperes.signum()) * amperes;
            assert!((said - is).abs() < 0.03, "{step:?} {amperes} A at half duty: said {said} A");
        }
    }
    // 2.057 V without current.
    assert_eq!(SHUNT_ZERO, (2.057 / LSB) as u16);
    assert!(BOARD.is_plausible());
}

#[test]
fn currents_of_locks_and_of_a_bridge_that_is_off_add_up() {
    let sampled = |mode| {
        move |shunts, step, duty| {
            let code = analog::bus_current(
                shunts,
                gates(step, Rectification::Synchronous),
                Duty::from_bits(duty),
                mode,
            );
            (f64::from(code) - 2048.0) * 0.008
        }
    };
    let amperes = sampled(SampleMode::OnTime);
    // Half of the period, less the dead time of 0.8 us.
    const HALF: f64 = 0.5 - 0.008;
    // 34 codes are an ampere. A switched, B and C low: half of it returns through each.
    assert!((amperes([0, 34, 34], Step::LockA, 16_384) - 2.0 * HALF).abs() < 0.01);
    // A and B switched, C low.
    assert!((amperes([0, 0, 34], Step::LockAB, 16_384) - HALF).abs() < 0.01);
    // Off: what comes up through a diode from ground goes to the bus.
    assert!((amperes([-34, 0, 0], Step::Coast, 0) + 1.0).abs() < 0.02);
    // Beyond the range the code stays at its end.
    assert_eq!(
        analog::bus_current(
            [0, 4095, 0],
            gates(Step::AB, Rectification::Synchronous),
            Duty::ONE,
            SampleMode::OnTime
        ),
        4095
    );
}

#[test]
fn a_switched_terminal_beyond_its_divider_is_at_the_bus() {
    // 24 V, which the divider of the terminals cannot show.
    let bus = 2867;
    let seen = |gates, mode| terminal(4095, gates, mode, bus);
    assert_eq!(seen(Gates::Complementary, SampleMode::OnTime), bus);
    assert_eq!(seen(Gates::HighOnly, SampleMode::OnTime), bus);
    // A floating one stays at the divider's end, 18.3 V: above the half of any bus up to 25 V.
    let end = seen(Gates::Off, SampleMode::OnTime);
    assert_eq!(end, 2185);
    assert!(2 * end > 2990);
    assert_eq!(seen(Gates::Complementary, SampleMode::OffTime), end);
}

#[test]
fn the_thermistor_is_10_kohm_over_4700_ohm() {
    // R = 10 kohm exp(B (1 / T - 1 / 298.15 K)), B = 3435 K; the divider's lower resistor is read.
    for tenths in -200..=1300 {
        let celsius = f64::from(tenths) / 10.0;
        let ntc = 10_000.0 * (3435.0_f64 * (1.0 / (celsius + 273.15) - 1.0 / 298.15)).exp();
        let code = (4096.0_f64 * 4700.0 / (4700.0 + ntc)).round() as u16;
        let said = degrees(analog::temperature(code));
        assert!((said - celsius).abs() < 0.8, "{celsius} degrees: code {code}, said {said}");
    }
    // 1.055 V at 25 degrees (ST).
    let code = (1.055 / 3.3 * 4096.0) as u16;
    assert!((degrees(analog::temperature(code)) - 25.0).abs() < 1.0);
    // Broken wires end at the table's ends.
    assert_eq!([0, 4095].map(|code| degrees(analog::temperature(code)).round()), [-20.0, 130.0]);
}

#[test]
fn pins_and_reference_are_volts() {
    assert!((volts(analog::pin(2048)) - 1.65).abs() < 0.001);
    assert!((volts(analog::pin(4095)) - 3.3).abs() < 0.002);
    // A chip whose reference reads 1655 at 3.0 V and 1504 now has 3.3 V.
    assert!((volts(analog::reference_tap(1504, 1655)) - 0.383 * 3.3).abs() < 0.002);
    assert!(volts(analog::reference_tap(0, 1655)) > 0.0, "a converter that has not converted yet");
}

#[test]
fn the_comparators_trip_between_what_is_allowed_and_what_breaks() {
    // 0.1286 V of bias and 0.571 of 3 milliohm. The threshold that ST's own set-up uses for 45 A is 4083 of
    // 65 536.
    assert!((f64::from(analog::trip_code(45)) - 4083.0 / 16.0).abs() < 1.0);
    let amperes =
        |code: u16, offset: f64| ((f64::from(code) * 3.3 / 4096.0 + offset) - 0.128_563) / 0.001_713;
    let code = analog::trip_code(25);
    for offset in [-0.009, 0.009] {
        let trips = amperes(code, offset);
        assert!((12.0..40.0).contains(&trips), "{offset} V of offset: {trips} A");
    }
}

#[test]
fn the_converters_fit_their_place_in_the_period() {
    let clock = 42.5e6;
    let conversion = (12.5 + 12.5) / clock;
    assert!((f64::from(SKEW) / 65_536.0 * 1e-4 - 3.0 * conversion).abs() < 2e-9);
    let sequence = (47.5 + 12.5 + 2.0 * 25.0) / clock;
    let earliest = f64::from(BOARD.earliest) / 65_536.0 * 1e-4;
    assert!(sequence < 2.7e-6 && earliest > sequence + 20e-6, "{sequence} s, {earliest} s");
}

/// Captured edges in a period that began at count `start`, with the lines `hall` now.
fn edges(captures: &[(u8, u16)], start: u16, hall: u8) -> (Vec<(u16, u8)>, u8, Edges) {
    let mut edges = Edges::default();
    let lost = captures.iter().map(|(line, at)| u8::from(edges.push(Capture { line: *line, at: *at }))).sum();
    let mut samples = Samples { hall, edges_lost: lost, ..Samples::default() };
    edges.take(start, &mut samples);
    let seen = samples.edges.iter().map(|Edge { instant, source, code }| {
        assert_eq!(*source, EdgeSource::Hall);
        (*instant, *code)
    });
    (seen.collect(), samples.edges_lost, edges)
}

#[test]
fn edges_belong_to_their_period_in_their_order() {
    // The period before lasted from count 500 to 17 500. Lines are 101 now.
    let (seen, lost, _) = edges(&[(2, 4_750)], 17_500, 0b101);
    assert_eq!((seen, lost), (vec![(instant(4_250), 0b101)], 0));
    // Two lines, captured in whatever order they are read: each code is the lines after its edge.
    let (seen, ..) = edges(&[(2, 9_000), (0, 4_750)], 17_500, 0b101);
    assert_eq!(seen, [(instant(4_250), 0b001), (instant(8_500), 0b101)]);
    // On the boundary itself begins the new period; one count before ends the old one.
    let (seen, _, held) = edges(&[(0, 17_500), (1, 17_499)], 17_500, 0b011);
    assert_eq!(seen, [(instant(16_999), 0b010)]);
    // The other one comes a tick later, at instant 0.
    let mut held = held;
    let mut samples = Samples { hall: 0b011, ..Samples::default() };
    held.take(34_500, &mut samples);
    assert_eq!(samples.edges.as_slice(), [Edge { instant: 0, source: EdgeSource::Hall, code: 0b011 }]);
    // Across the wrap of the counter.
    let (seen, ..) = edges(&[(1, 65_000)], 100, 0b010);
    assert_eq!(seen, [(instant(17_000 - 636), 0b010)]);
}

#[test]
fn edges_that_found_no_room_or_no_period_are_counted() {
    // The processor stood still for two periods.
    let (seen, lost, _) = edges(&[(1, 0)], 30_000, 0b010);
    assert_eq!((seen.len(), lost), (0, 1));
    // Four fit a tick.
    let captures = [(0, 1_000), (1, 2_000), (2, 3_000), (0, 4_000), (1, 5_000)];
    let (seen, lost, _) = edges(&captures, 17_000, 0b100);
    assert_eq!((seen.len(), lost), (4, 1));
    let seven = [(0, 1_000), (1, 2_000), (2, 3_000), (0, 4_000), (1, 5_000), (2, 6_000), (0, 7_000)];
    let (seen, lost, _) = edges(&seven, 17_000, 0b100);
    assert_eq!((seen.len(), lost), (4, 3));
}

#[test]
fn bits_are_sampled_at_seven_eighths() {
    let timing =
        |clock, rate| BitTiming::of(clock, rate).map(|bit| (bit.prescaler, bit.segment_1, bit.segment_2));
    for (clock, rate, expected) in [
        (CLOCK_HZ, BIT_RATE, Some((1, 13, 2))),
        (8_000_000, 250_000, Some((1, 27, 4))),
        (8_000_000, 1_000_000, Some((1, 6, 1))),
        (170_000_000, 500_000, Some((10, 28, 5))),
        (8_000_000, 333_333, None),
        (8_000_000, 0, None),
    ] {
        assert_eq!(timing(clock, rate), expected, "{clock} Hz, {rate} bit/s");
    }
    // Fields NSJW, NBRP, NTSEG1, NTSEG2, each less 1.
    assert_eq!(BitTiming::of(CLOCK_HZ, BIT_RATE).map(|bit| bit.register()), Some(1 << 25 | 12 << 8 | 1));
}

#[test]
fn frames_are_elements_of_the_message_memory() {
    let extended =
        |raw, bytes: &[u8]| Frame::data(Id::extended(raw).expect("29 bits"), bytes).expect("8 bytes");
    let standard =
        |raw, bytes: &[u8]| Frame::data(Id::standard(raw).expect("11 bits"), bytes).expect("8 bytes");
    let remote = Frame::remote(Id::standard(0x7FF).expect("11 bits"), 3).expect("8 bytes");
    let table = [
        (extended(0x1FFF_FFFF, &[]), [0x5FFF_FFFF, 0, 0, 0]),
        (extended(0x0AA_0155, &[1, 2, 3, 4, 5, 6, 7, 8]), [0x40AA_0155, 8 << 16, 0x0403_0201, 0x0807_0605]),
        (standard(0x123, &[0xFF]), [0x123 << 18, 1 << 16, 0xFF, 0]),
        (remote, [0x7FF << 18 | 1 << 29, 3 << 16, 0, 0]),
    ];
    for (frame, words) in table {
        assert_eq!(encode(&frame), words, "{frame:?}");
        // Flags of reception, a time stamp, and what stood in the memory before do not matter.
        let [head, length, ..] = words;
        let dirty = [head | 1 << 31, length | 0x8000_1234, words[2], words[3]];
        assert_eq!(decode(dirty), Some(frame));
    }
    let stale = [0x123 << 18, 1 << 16, 0xDDCC_BBAA, 0x1111_1111];
    assert_eq!(decode(stale), Some(standard(0x123, &[0xAA])), "bytes beyond the length are nobody's");
    let long = [0x123 << 18, 15 << 16, 0, 0];
    assert_eq!(decode(long).map(|frame| frame.dlc()), Some(8), "ISO 11898-1: above 8 is 8");
}

#[test]
fn the_controllers_word_is_its_state() {
    for (psr, ecr, error, transmit, receive) in [
        (0x0000_0707, 0, ErrorState::Active, 0, 0),
        (1 << 5, 128, ErrorState::Passive, 128, 0),
        (1 << 5, 1 << 15 | 127 << 8, ErrorState::Passive, 0, 128),
        (1 << 7 | 1 << 5, 255, ErrorState::BusOff, 255, 0),
    ] {
        let state = bus_state(psr, ecr);
        assert_eq!(
            (state.error, state.transmit_errors, state.receive_errors),
            (error, transmit, receive),
            "{psr:x} {ecr:x}"
        );
    }
}

#[test]
fn the_flash_is_divided_without_gaps_and_the_linker_agrees() {
    let regions = [MAP.bootloader, MAP.active, MAP.dfu, MAP.state, MAP.parameters];
    assert_eq!(regions.each_ref().map(|region| (region.end - region.start) >> 10), [22, 96, 0, 2, 8]);
    let mut end = 0;
    for region in regions {
        assert!(region.start == end && region.end.is_multiple_of(PAGE), "{region:?}");
        end = region.end;
    }
    assert_eq!(end, SIZE);
    let origin = |linker: &str, address: u32| linker.contains(&format!("ORIGIN = 0x{address:08X}"));
    assert!(origin(include_str!("../slot.x"), START + MAP.entry()));
    assert!(origin(include_str!("../boot.x"), START));
    // The vector table of 16 + 102 words begins at a multiple of the next power of two (PM0214, SCB_VTOR).
    assert!(MAP.entry().is_multiple_of(512));
}

#[test]
fn every_pin_has_one_use_and_the_ports_say_so() {
    for (index, pin) in PINS.iter().enumerate() {
        let again = PINS[..index].iter().find(|other| (other.port, other.number) == (pin.port, pin.number));
        assert_eq!(again.map(|other| other.name), None, "{}", pin.name);
    }
    // Ports A and B keep the debugger's pins as after reset (RM0440, GPIOx_MODER and GPIOx_PUPDR).
    let a = words(Port::A);
    assert_eq!((a.mode >> 26 & 0xF, a.pull >> 26 & 0xF), (0b1010, 0b1001));
    // The gates: alternate functions of TIM1 (DS12589, table 13), pulled down.
    assert_eq!(a.alternate[1] & 0x000F_0FFF, 0x0006_0666);
    assert_eq!(words(Port::B).alternate[1] >> 28, 4);
    let c = words(Port::C);
    assert_eq!((c.mode >> 26 & 3, c.alternate[1] >> 20 & 0xF, c.pull >> 26 & 3), (0b10, 4, 0b10));
    // Transceiver on, 120 ohm on; dividers of the terminals on.
    assert_eq!((c.output >> 11 & 1, c.output >> 14 & 1), (0, 1));
    assert_eq!(words(Port::B).output >> 5 & 1, 0);
    let gates = PINS.iter().filter(|pin| pin.name.starts_with("TIM1"));
    assert!(gates.clone().all(|pin| matches!(pin.function, Function::Alternate(_))) && gates.count() == 6);
}

/// docs/B-G431B-ESC1.md, "What it cannot do": both digital lines can be read, and that is all.
#[test]
fn what_the_board_lacks_is_in_its_table() {
    use narx_core::bus::narmotion::ParameterStatus;
    use narx_core::dictionary::number;
    use narx_core::motor::{Equipment, State, Status};
    use narx_core::node::{Identity, Node};
    assert_eq!(BOARD.equipment, Equipment::DIGITAL_INPUTS);
    let mut node = Node::new(Identity::default(), BOARD);
    node.handle_status(Status { state: State::Standby, ..Status::default() });
    for (number, value, status) in [
        (number::TEMPERATURE_SOURCE, 1, ParameterStatus::NotEquipped),
        (number::HALL_SUPPLY_ENABLE, 0, ParameterStatus::NotEquipped),
        (number::LOGGING_SLOT_FIRST, 8, ParameterStatus::NotEquipped),
        (number::SHUTDOWN_INPUT, 2, ParameterStatus::Done),
    ] {
        assert_eq!(node.write_parameter(number, value), status, "{number}");
    }
}
