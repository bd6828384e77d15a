//! Tests of the log as a master downloads it from a scripted drive: ranges, records and their CRC, gaps,
//! aborts.

use crate::download_bench::{Bench, Device, sent};
use crate::pair::said;
use narx_core::bus::narmotion::{FromDrive, ParameterStatus, ToDrive};
use narx_core::dictionary::number;
use narx_core::master::{Config, Download, DownloadError, Master, Request};
use narx_core::storage::{Entry, Record};
use std::collections::BTreeSet;

#[test]
fn the_log_is_read_by_range() {
    let mut bench = Bench::new(Device::new(0, 18));
    let words = bench.download(Download::Log { first: 3, records: 5 }).unwrap();
    assert_eq!(words, bench.device.log[27..72]);
    let set = |number, value| ToDrive::SetParameter { number, value };
    let asked = [
        ToDrive::RequestParameter { number: number::LOG_RECORD_BYTES },
        set(number::LOG_READ_START, 3),
        set(number::LOG_READ_COUNT, 5),
        set(number::LOG_READ_REQUEST, 0),
        set(number::LOG_READ_REQUEST, 1),
    ];
    assert_eq!(bench.device.asked, asked);
    assert_eq!(bench.download(Download::Log { first: 0, records: 0 }), Ok(vec![]));
    // The word counter has 16 bits, and wraps.
    let words = bench.download(Download::Log { first: 0, records: 15_000 }).unwrap();
    assert_eq!(words, bench.device.log[..135_000]);
}

#[test]
fn of_the_log_only_the_gap_is_asked_for() {
    let mut bench = Bench::new(Device::new(0, 24));
    bench.device.lost = BTreeSet::from([50]);
    assert!(bench.download(Download::Log { first: 7, records: 100 }).is_ok());
    // Frame 50 has words 150 to 152: record 12 of the download, 19 of the log.
    let set = |number, value| ToDrive::SetParameter { number, value };
    let again = [
        set(number::LOG_READ_START, 19),
        set(number::LOG_READ_COUNT, 1),
        set(number::LOG_READ_REQUEST, 0),
        set(number::LOG_READ_REQUEST, 1),
    ];
    assert_eq!(bench.device.asked[5..], again);
}

/// A master with a log download whose stream was requested; the command's answer has not come yet.
fn raised(records: u32) -> Master {
    let mut master = Master::new(Config { read_parameters: false, ..Config::default() });
    master.download(Download::Log { first: 0, records }).unwrap();
    loop {
        let (number, value) = match sent(&mut master, 0)[..] {
            [ToDrive::RequestParameter { number }] => (number, 18),
            [ToDrive::SetParameter { number: number::LOG_READ_REQUEST, value: 1 }] => return master,
            [ToDrive::SetParameter { number, value }] => (number, value),
            ref other => panic!("{other:?}"),
        };
        master.handle_frame(&said(FromDrive::Parameter { number, value, status: ParameterStatus::Done }), 0);
    }
}

const RAISED: FromDrive =
    FromDrive::Parameter { number: number::LOG_READ_REQUEST, value: 1, status: ParameterStatus::Done };

/// Words of one record, frame by frame.
fn frames_of(index: u32) -> Vec<[u16; 3]> {
    let record = Record::new(index, &Entry::default());
    (0..3).map(|place| record.frame(place).unwrap()).collect()
}

#[test]
fn log_words_find_their_place_in_any_order() {
    let mut master = raised(2);
    let words = [frames_of(0), frames_of(1)].concat();
    let data = |place: u16| {
        let data = words[usize::from(place)];
        said(FromDrive::LogData { counter: place * 3, data })
    };
    // The first words arrive before the answer.
    master.handle_frame(&data(1), 1);
    master.handle_frame(&said(RAISED), 2);
    for place in [0, 0, 2, 1, 4, 3, 5] {
        master.handle_frame(&data(place), 3);
    }
    let offsets: Vec<u32> = std::iter::from_fn(|| master.poll_chunk()).map(|chunk| chunk.offset).collect();
    assert_eq!(offsets, [3, 0, 6, 12, 9, 15]);
    assert_eq!(master.poll_download(), Some(Ok(18)));
}

/// A record that arrives complete but differs from the written one is requested again: a wrong bit in any of
/// its words, its number, or the number of another.
#[test]
fn a_record_counts_when_its_crc_is_right() {
    for bit in [0, 16, 47, 48, 80, 100, 140, 143] {
        let mut master = raised(2);
        master.handle_frame(&said(RAISED), 1);
        let mut words = [frames_of(0), frames_of(1)].concat();
        words[3 + bit / 48][bit % 48 / 16] ^= 1 << (bit % 16);
        for (place, data) in words.into_iter().enumerate() {
            master.handle_frame(&said(FromDrive::LogData { counter: place as u16 * 3, data }), 2);
        }
        while master.poll_chunk().is_some() {}
        assert_eq!(master.poll_download(), None, "bit {bit}");
        let again = ToDrive::SetParameter { number: number::LOG_READ_START, value: 1 };
        assert_eq!(sent(&mut master, 3), [again], "bit {bit}");
    }
    let mut master = raised(1);
    master.handle_frame(&said(RAISED), 1);
    for (place, data) in frames_of(1).into_iter().enumerate() {
        master.handle_frame(&said(FromDrive::LogData { counter: place as u16 * 3, data }), 2);
    }
    assert_eq!(master.poll_download(), None, "record 1 where record 0 should be");
}

/// Words across two frames of a record, which no drive sends, make no record: with the zeros of a record that
/// cannot be read they would pass for one, and the caller would miss a word of it.
#[test]
fn words_across_frames_make_no_record() {
    let mut master = raised(1);
    master.handle_frame(&said(RAISED), 1);
    // Nor do they end the pass, although the last of them ends with the record.
    for counter in [1, 4, 7] {
        master.handle_frame(&said(FromDrive::LogData { counter, data: [0; 3] }), 2);
        assert!(master.poll_chunk().is_none(), "{counter}");
    }
    assert_eq!((sent(&mut master, 3), master.poll_download()), (vec![], None));
    for (place, data) in frames_of(0).into_iter().enumerate() {
        master.handle_frame(&said(FromDrive::LogData { counter: place as u16 * 3, data }), 3);
    }
    assert_eq!(std::iter::from_fn(|| master.poll_chunk()).count(), 3);
    assert_eq!(master.poll_download(), Some(Ok(9)));
}

#[test]
fn a_record_that_stays_spoiled_is_named() {
    let mut bench = Bench::new(Device::new(0, 24));
    bench.device.log[12 * 17 + 5] ^= 0x0100;
    let end = bench.download(Download::Log { first: 3, records: 100 });
    assert_eq!(end, Err(DownloadError::Spoiled { record: 17 }));
    assert_eq!(end.unwrap_err().to_string(), "record 17 of the log has a wrong number or CRC");
    assert_eq!(bench.download(Download::Log { first: 18, records: 100 }).unwrap().len(), 1200);
}

#[test]
fn zeros_stand_for_a_record_that_the_drive_cannot_read() {
    let mut bench = Bench::new(Device::new(0, 24));
    bench.device.log[12 * 17..12 * 18].fill(0);
    let words = bench.download(Download::Log { first: 3, records: 100 }).unwrap();
    assert!(words == bench.device.log[36..1236]);
    assert_eq!(bench.device.asked.len(), 5, "and are not asked for again");
}

/// A caller that takes one chunk per tick gets every record, at four frames per tick and forty per record:
/// there is room for less than one record in between.
#[test]
fn a_slow_caller_gets_every_record() {
    for appetite in [1, 2, 3] {
        let mut bench = Bench::new(Device::new(0, 240));
        bench.appetite = appetite;
        let words = bench.download(Download::Log { first: 5, records: 20 }).unwrap();
        assert!(words == bench.device.log[600..3000], "{appetite}");
    }
}

/// A caller that sleeps until the next poll is due is not woken for a record for which there is no room until
/// it has taken the received chunks.
#[test]
fn a_gap_is_asked_for_when_there_is_room() {
    let mut master = raised(2);
    master.handle_frame(&said(RAISED), 1);
    // The middle of the first record is lost.
    for (place, data) in [frames_of(0), frames_of(1)].concat().into_iter().enumerate() {
        if place != 1 {
            master.handle_frame(&said(FromDrive::LogData { counter: place as u16 * 3, data }), 2);
        }
    }
    let period = master.config().setpoint_period;
    for left in (1..=5).rev() {
        assert_eq!((sent(&mut master, 3), master.next_poll(3)), (vec![], period), "{left} chunks wait");
        assert!(master.poll_chunk().is_some());
    }
    assert_eq!(master.next_poll(3), 3);
    assert_eq!(sent(&mut master, 3), [ToDrive::SetParameter { number: number::LOG_READ_START, value: 0 }]);
}

#[test]
fn a_log_of_another_form_is_none() {
    for bytes in [0, 17, 20, 246, -1] {
        let mut bench = Bench::new(Device::new(0, 18));
        bench.device.parameters.insert(number::LOG_RECORD_BYTES, bytes);
        let end = bench.download(Download::Log { first: 0, records: 1 });
        assert_eq!(end, Err(DownloadError::NoLog), "{bytes}");
    }
}

#[test]
fn a_stream_that_begins_after_its_abort_is_stopped() {
    let mut master = raised(5);
    master.abort_download();
    assert_eq!(sent(&mut master, 1), [], "one message at a time");
    master.handle_frame(&said(RAISED), 2);
    assert_eq!(sent(&mut master, 3), [ToDrive::SetParameter { number: number::LOG_READ_REQUEST, value: 0 }]);
    assert_eq!(master.poll_download(), None);
    let lowered =
        FromDrive::Parameter { number: number::LOG_READ_REQUEST, value: 0, status: ParameterStatus::Done };
    master.handle_frame(&said(lowered), 4);
    assert_eq!(master.poll_download(), Some(Err(DownloadError::Aborted)));
}

#[test]
fn an_abort_is_in_time_at_any_time() {
    for ticks in 0..40 {
        let mut bench = Bench::new(Device::new(60, 24));
        bench.master.download(Download::Log { first: 0, records: 20 }).unwrap();
        (0..ticks).for_each(|_| bench.step());
        bench.master.abort_download();
        let (end, _) = bench.end();
        assert!(matches!(end, Err(DownloadError::Aborted) | Ok(240)), "{ticks}: {end:?}");
        assert_eq!(bench.device.stream.len(), 0, "{ticks}");
        assert_eq!(bench.download(Download::Scope { words: 60 }), Ok(bench.device.scope.clone()), "{ticks}");
    }
}

#[test]
fn commands_and_requests_go_before_the_download() {
    let mut bench = Bench::new(Device::new(0, 24));
    bench.master.download(Download::Log { first: 0, records: 10 }).unwrap();
    bench.master.request(Request::Read { number: 5 }).unwrap();
    bench.master.start(1000);
    let frames: Vec<ToDrive> = std::iter::from_fn(|| bench.master.poll_frame(0))
        .map(|frame| ToDrive::decode(&frame).unwrap().1)
        .collect();
    assert_eq!(frames.len(), 3);
    assert!(
        matches!(frames[0], ToDrive::MotorCommand { .. }) && matches!(frames[1], ToDrive::RequestWord(_))
    );
    assert_eq!(frames[2], ToDrive::RequestParameter { number: 5 });
}
