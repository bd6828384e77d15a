//! Tests of master and node over a line that loses, delays, doubles and reorders frames.

use crate::pair::{Fate, Pair};
use narx_core::bus::narmotion::MotorMode;
use narx_core::dictionary::{Access, Dictionary, PARAMETER_COUNT, number};
use narx_core::master::{Config, Request, RequestError, Service};
use proptest::prelude::*;
use std::collections::BTreeSet;

/// Strategy of a bad line: delays of the frames, us; half of them arrive at once. The second copy of a frame
/// comes up to `apart` later.
fn fates(latest: u64, apart: u64) -> impl Strategy<Value = Vec<Fate>> {
    let fate = prop_oneof![
        4 => Just(vec![0]),
        1 => Just(vec![]),
        1 => (0..latest).prop_map(|delay| vec![delay]),
        1 => (0..latest, 0..=apart).prop_map(|(one, later)| vec![one, one + later]),
    ];
    prop::collection::vec(fate, 0..600)
}

fn requests() -> impl Strategy<Value = Vec<Request>> {
    let number = prop_oneof![4 => 0..122_u16, 1 => 256..290_u16, 1 => Just(9999)];
    let raw = prop_oneof![0..2_i32, 0..5000_i32, any::<i32>()];
    let request = prop_oneof![
        number.clone().prop_map(|number| Request::Read { number }),
        (number, raw).prop_map(|(number, raw)| Request::Write { number, raw }),
        Just(Request::BuildInfo),
        Just(Request::DeviceInfo),
        Just(Request::Run(Service::ResetCalibration)),
        Just(Request::Run(Service::SetPosition)),
        any::<bool>().prop_map(Request::DisableHallSupply),
    ];
    prop::collection::vec(request, 1..12)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// If frames are lost, doubled as CAN doubles them, and delayed by less than half of the time-out, the
    /// master's answers are true. (The late double of a refusal may match another write of the same
    /// parameter: each is written once here. The late double of a read with the value that is written counts
    /// as the answer: the parameter has that value, also if it is the drive's own.)
    #[test]
    fn answers_are_true(requests in requests(), fates in fates(49_000, 0)) {
        let mut pair = Pair::quiet();
        pair.fates = fates.into();
        let mut written = BTreeSet::new();
        for request in requests {
            let parameter = match request {
                Request::Write { number, .. } => Some(number),
                Request::Run(service) => Some(service as u16),
                _ => None,
            };
            if parameter.is_some_and(|number| !written.insert(number)) {
                continue;
            }
            let before = pair.bench.node.parameters().clone();
            let answer = pair.ask(request);
            prop_assert_eq!(answer.request, request);
            let node = &pair.bench.node;
            match (request, answer.result) {
                (Request::Read { number }, Ok(value)) => {
                    let live = Dictionary::row(number).unwrap().access == Access::ReadOnly;
                    prop_assert!(live || node.read_parameter(number) == Some(value));
                }
                (Request::Write { number, raw }, Ok(value)) => {
                    prop_assert_eq!((value, node.read_parameter(number)), (raw, Some(raw)));
                }
                (Request::Write { number, raw }, Err(RequestError::Refused(refusal))) => {
                    prop_assert_eq!((refusal.number, refusal.offered), (number, Some(raw)));
                    prop_assert_eq!(node.parameters(), &before);
                }
                (Request::Read { number }, Err(RequestError::Refused(_))) => {
                    prop_assert!(Dictionary::row(number).is_none());
                }
                (Request::Run(service), Ok(value)) => {
                    prop_assert_eq!((value, node.parameters().value(service as u16)), (1, Some(1)));
                }
                (_, Ok(_) | Err(RequestError::NoAnswer | RequestError::NotObeyed)) => {}
                (request, Err(error)) => prop_assert!(false, "{request:?}: {error}"),
            }
        }
    }

    /// However late frames are, in any order, every request has one answer in its turn, the drive gets its
    /// commands, and once the line is good again everything works.
    #[test]
    fn a_line_that_gets_well_is_well(requests in requests(), fates in fates(400_000, 400_000)) {
        let mut pair = Pair::new(Config { read_parameters: true, ..Config::default() });
        (pair.fates, pair.disorderly) = (fates.into(), true);
        pair.master.start(1234);
        let mut answered = Vec::new();
        let mut waiting = requests.clone().into_iter().peekable();
        for _ in 0..60_000 {
            if let Some(request) = waiting.next_if(|request| pair.master.request(*request).is_ok()) {
                prop_assert!(requests.contains(&request));
            }
            pair.step();
            answered.extend(pair.master.poll_answer().map(|answer| answer.request));
        }
        prop_assert_eq!(&answered, &requests);

        pair.fates.clear();
        pair.run(1500);
        pair.master.read_parameters();
        pair.run(500);
        prop_assert!(pair.master.is_connected(pair.now));
        prop_assert_eq!((pair.master.parameters().known(), pair.master.parameters_to_read()), (PARAMETER_COUNT, 0));
        for (row, received) in pair.master.parameters().iter() {
            let live = row.access == Access::ReadOnly;
            prop_assert!(live || received.map(|received| received.value) == pair.bench.node.parameters().value(row.number));
        }
        prop_assert_eq!(pair.master.requested(), Some(MotorMode::Drive));
        let rate = pair.ask(Request::Write { number: number::SPEED_RATE, raw: 777 });
        prop_assert_eq!(rate.result, Ok(777));
        // The drive refuses no frame but the requested ones, whatever the line does.
        prop_assert_eq!(pair.bench.malformed(), 0);
    }
}
