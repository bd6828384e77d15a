//! Tests of bulk downloads from a scripted drive: lengths, streams, gaps, refusals, aborts.

use crate::download_bench::{Bench, Device, sent};
use crate::pair::said;
use narx_core::bus::narmotion::{Addresses, FromDrive, ParameterStatus, ToDrive, XmlCommand};
use narx_core::dictionary::number;
use narx_core::master::{Config, Download, DownloadError, Master, NotTaken, Progress};
use proptest::prelude::*;

#[test]
fn the_description_is_asked_for_its_length_and_then_streams() {
    // One, two and three words in the last frame.
    for words in [1, 2, 3, 100, 1000, 1001, u16::MAX] {
        let mut bench = Bench::new(Device::new(words, 0));
        assert_eq!(bench.download(Download::Description), Ok(bench.device.description.clone()));
        let asked = [XmlCommand::Length, XmlCommand::Start].map(ToDrive::DownloadXml);
        assert_eq!(bench.device.asked, asked, "{words}");
    }
    let mut bench = Bench::new(Device::new(0, 0));
    assert_eq!(bench.download(Download::Description), Ok(vec![]));
}

#[test]
fn text_is_packed_high_byte_first_and_samples_are_q3_12() {
    let mut bench = Bench::new(Device::new(0, 0));
    bench.appetite = 0;
    bench.device.description = vec![0x3C3F, 0x786D, 0x6C20, 0x7600];
    bench.device.scope = vec![0x1000, 0xF000, 0x0800, 0x8000];
    bench.master.download(Download::Description).unwrap();
    bench.run(10);
    let chunks: Vec<_> = std::iter::from_fn(|| bench.master.poll_chunk()).collect();
    let text: Vec<u8> = chunks.iter().flat_map(|chunk| chunk.bytes()).collect();
    assert_eq!(text, b"<?xml v\0");
    assert_eq!(bench.master.poll_download(), Some(Ok(4)));
    bench.master.download(Download::Scope { words: 4 }).unwrap();
    bench.run(10);
    let chunks: Vec<_> = std::iter::from_fn(|| bench.master.poll_chunk()).collect();
    let samples: Vec<f64> =
        chunks.iter().flat_map(|chunk| chunk.samples()).map(|sample| sample.to_num()).collect();
    assert_eq!(samples, [1.0, -1.0, 0.5, -8.0]);
}

#[test]
fn the_scope_streams_at_once() {
    for words in [0, 5, 768, 40_000] {
        let mut bench = Bench::new(Device::new(words, 0));
        assert_eq!(bench.download(Download::Scope { words: words.into() }), Ok(bench.device.scope.clone()));
        let asked: &[ToDrive] = if words == 0 { &[] } else { &[ToDrive::DownloadScope] };
        assert_eq!(bench.device.asked, asked, "{words}");
    }
}

#[test]
fn gaps_are_asked_for_again() {
    // Losses: the first frame; the last one; one in the middle; several in a row; every seventh one.
    let losses: [&[usize]; 5] =
        [&[0], &[333], &[100], &[10, 11, 12, 200, 201], &[0, 7, 14, 21, 28, 35, 42, 49, 56]];
    for lost in losses {
        for what in
            [Download::Description, Download::Scope { words: 1000 }, Download::Log { first: 7, records: 100 }]
        {
            let mut bench = Bench::new(Device::new(1000, 24));
            bench.device.lost = lost.iter().copied().collect();
            let words = bench.download(what).unwrap();
            let expected = match what {
                Download::Description => bench.device.description.clone(),
                Download::Scope { .. } => bench.device.scope.clone(),
                Download::Log { .. } => bench.device.log[84..1284].to_vec(),
            };
            assert!(words == expected, "{what:?}, lost {lost:?}");
        }
    }
}

/// CAN may double a frame, and the master requests the next stream as soon as the last frame has come; its
/// double does not end that stream.
#[test]
fn the_double_of_a_last_frame_does_not_end_the_next_stream() {
    let mut master = Master::new(Config { read_parameters: false, ..Config::default() });
    let data =
        |address: u16| said(FromDrive::ScopeData { address, data: [address, address + 1, address + 2] });
    master.download(Download::Scope { words: 9 }).unwrap();
    assert_eq!(sent(&mut master, 0), [ToDrive::DownloadScope]);
    master.handle_frame(&data(0), 1);
    master.handle_frame(&data(6), 2);
    assert_eq!(sent(&mut master, 3), [ToDrive::DownloadScope], "3 to 5 are missing");
    master.handle_frame(&data(6), 4);
    assert_eq!(sent(&mut master, 5), []);
    master.handle_frame(&data(0), 6);
    master.handle_frame(&data(3), 7);
    let offsets: Vec<u32> = std::iter::from_fn(|| master.poll_chunk()).map(|chunk| chunk.offset).collect();
    assert_eq!((offsets, master.poll_download()), (vec![0, 6, 3], Some(Ok(9))));
}

#[test]
fn a_slow_caller_gets_everything() {
    let mut bench = Bench::new(Device::new(500, 0));
    bench.appetite = 1;
    assert_eq!(bench.download(Download::Description), Ok(bench.device.description.clone()));
}

#[test]
fn a_drive_that_does_not_know_downloads_does_not_answer() {
    let config = Config { read_parameters: false, ..Config::default() };
    for (what, milliseconds) in [(Download::Description, 300), (Download::Scope { words: 30 }, 1500)] {
        let mut master = Master::new(config);
        master.download(what).unwrap();
        assert_eq!(master.download(what), Err(NotTaken::Full));
        let ended = (0..3_000_000).step_by(100).find(|now| {
            while master.poll_frame(*now).is_some() {}
            master.poll_download() == Some(Err(DownloadError::NoAnswer))
        });
        assert_eq!(ended.map(|now| now / 1000), Some(milliseconds), "{what:?}");
    }
    // Without a log its records have no size; with a size, 75 is answered with status 5.
    let mut bench = Bench::new(Device::new(0, 0));
    assert_eq!(bench.download(Download::Log { first: 0, records: 1 }), Err(DownloadError::NoLog));
    let mut master = Master::new(config);
    master.download(Download::Log { first: 0, records: 1 }).unwrap();
    while let Some(frame) = master.poll_frame(0) {
        let (number, value, status) = match ToDrive::decode(&frame).unwrap().1 {
            ToDrive::RequestParameter { number } => (number, 18, ParameterStatus::Done),
            ToDrive::SetParameter { number: number::LOG_READ_REQUEST, value: 1 } => {
                (number::LOG_READ_REQUEST, 0, ParameterStatus::Storage)
            }
            ToDrive::SetParameter { number, value } => (number, value, ParameterStatus::Done),
            _ => continue,
        };
        master.handle_frame(&said(FromDrive::Parameter { number, value, status }), 0);
    }
    let end = master.poll_download().unwrap().unwrap_err();
    assert_eq!(
        end.to_string(),
        "parameter 75 \"Logging read request\": the parameter store or log memory is missing, busy or failed"
    );
}

#[test]
fn a_stream_that_breaks_off_is_asked_for_three_times_more() {
    let mut bench = Bench::new(Device::new(300, 0));
    bench.device.lost = (50..100_000).collect();
    bench.master.download(Download::Description).unwrap();
    let (end, at) = bench.end();
    assert_eq!(end, Err(DownloadError::NoAnswer));
    // The first stream brings 50 frames; three more bring nothing.
    let starts = bench.device.asked.iter().filter(|asked| **asked == ToDrive::DownloadXml(XmlCommand::Start));
    assert_eq!(starts.count(), 4);
    assert!((2000..2100).contains(&at), "{at} ms");
}

#[test]
fn progress_is_told_and_a_download_can_be_aborted() {
    for what in
        [Download::Description, Download::Scope { words: 3000 }, Download::Log { first: 0, records: 250 }]
    {
        let mut bench = Bench::new(Device::new(3000, 24));
        bench.master.download(what).unwrap();
        assert_eq!(bench.master.download_progress().map(|progress| progress.received).unwrap_or(0), 0);
        bench.run(10);
        let Progress { received, total } = bench.master.download_progress().unwrap();
        assert!((300..2000).contains(&received) && total == 3000, "{received} of {total}");
        bench.master.abort_download();
        let (end, at) = bench.end();
        assert_eq!((end, at), (Err(DownloadError::Aborted), 10), "{what:?}");
        let stop = match what {
            Download::Description => Some(ToDrive::DownloadXml(XmlCommand::Length)),
            // No message stops the scope; frames that still come are ignored.
            Download::Scope { .. } => None,
            Download::Log { .. } => {
                Some(ToDrive::SetParameter { number: number::LOG_READ_REQUEST, value: 0 })
            }
        };
        assert_eq!(bench.device.stream.is_empty(), stop.is_some());
        assert!(stop.is_none_or(|stop| bench.device.asked.last() == Some(&stop)));
        bench.run(10);
        assert_eq!((bench.master.poll_chunk(), bench.master.poll_download()), (None, None));
        assert_eq!(bench.download(Download::Description), Ok(bench.device.description.clone()));
    }
}

#[test]
fn a_silent_master_downloads_nothing() {
    let mut master = Master::new(Config { silent: true, ..Config::default() });
    assert_eq!(master.download(Download::Description), Err(NotTaken::Silent));
    // Words that another master has requested are not its own.
    let data = FromDrive::XmlData { address: 0, data: [1, 2, 3] };
    master.handle_frame(&data.encode(Addresses::FACTORY), 0);
    assert_eq!(master.poll_chunk(), None);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// With any losses in the streams a download is complete and right in the end, or fails.
    #[test]
    fn downloads_are_complete_or_fail(
        kind in 0..3_u8,
        words in 1..1500_u16,
        values in 0..=37_u32,
        lost in prop::collection::btree_set(0..2000_usize, 0..300),
        appetite in 1..6_usize,
    ) {
        let record = 18 + 6 * values;
        let mut bench = Bench::new(Device::new(words, record as i32));
        (bench.device.lost, bench.appetite) = (lost, appetite);
        let records = u32::from(words) * 2 / record;
        let (what, expected) = match kind {
            0 => (Download::Description, bench.device.description.clone()),
            1 => (Download::Scope { words: words.into() }, bench.device.scope.clone()),
            _ => {
                let size = (record / 2 * records) as usize;
                (Download::Log { first: 0, records }, bench.device.log[..size].to_vec())
            }
        };
        match bench.download(what) {
            Ok(words) => prop_assert!(words == expected),
            Err(error) => prop_assert_eq!(error, DownloadError::NoAnswer),
        }
        // Without disturbance it works.
        bench.device.lost.clear();
        prop_assert!(bench.download(what) == Ok(expected));
    }
}
