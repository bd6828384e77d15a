//! An update of the virtual drive over its simulated bus, at its speed.

use narx_boot::sign::SecretKey;
use narx_boot::{Header, Version, hardware};
use narx_core::bus::narmotion::update::UpdateCode;
use narx_core::commissioning::Mode;
use narx_core::master::{Image, UpdateError};
use narx_core::motor::State;
use narx_sim::presets::PRESETS;
use narx_sim::session::{Session, SessionConfig};

fn session() -> Session {
    let motor = PRESETS[0].motor;
    let mut session = Session::new(&SessionConfig::new(motor, 24.0, Mode::Hall)).unwrap();
    session.run(0.7);
    session
}

const VERSION: Version = Version { major: 0, minor: 2, patch: 1, build: 77 };

fn image(version: Version, body: usize) -> (Image, Vec<u8>) {
    let body: Vec<u8> = (0..body).map(|at| (at * 7 + at / 256) as u8).collect();
    let header = Header { hardware: hardware::BENCH, version, length: 0 };
    let mut bytes = SecretKey::TEST_ONLY.sign(header, &body).to_vec();
    bytes.extend(body);
    (Image::new(hardware::BENCH, version.into(), &bytes), bytes)
}

fn update(session: &mut Session, (image, bytes): (Image, Vec<u8>)) -> Result<(), UpdateError> {
    session.update(image, bytes).unwrap();
    for _ in 0..200_000 {
        session.step();
        if let Some(end) = session.master().poll_update() {
            return end;
        }
    }
    panic!("no end: {:?}", session.master().update_progress());
}

/// The image runs, its sending takes little more than its frames on the bus, and the drive starts afterwards
/// as it did before.
#[test]
fn the_virtual_drive_takes_an_image() {
    let mut session = session();
    let before = session.bench().time();
    assert_eq!(update(&mut session, image(VERSION, 40_000)), Ok(()));
    let took = session.bench().time() - before;
    // 6752 blocks every 400 us are 2.7 s; 20 pages take 0.44 s to erase.
    assert!((2.7..4.0).contains(&took), "{took} s");
    session.start(1500);
    session.run(1.0);
    assert_eq!(session.bench().status().state, State::HallClosedLoop);
}

#[test]
fn the_virtual_drive_refuses_what_a_real_one_would() {
    let mut unsigned = image(VERSION, 1000);
    unsigned.1[700] ^= 1;
    unsigned.0 = Image::new(hardware::BENCH, VERSION.into(), &unsigned.1);
    assert_eq!(update(&mut session(), unsigned), Err(UpdateError::Refused(UpdateCode::Signature)));

    let mut driving = session();
    driving.start(1500);
    driving.run(1.0);
    let refused = update(&mut driving, image(VERSION, 1000));
    assert_eq!(refused, Err(UpdateError::Refused(UpdateCode::WrongState)));
    assert_eq!(driving.bench().status().state, State::HallClosedLoop);
}
