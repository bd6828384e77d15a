//! Tests that a write lasts: values that a master has written are stored automatically, and restored ones
//! stay restored (decisions 22 and 24 of PROTOCOL.md).

use crate::device::Device;
use crate::node::device;
use crate::support::{boot, set, small};
use narx_core::bus::narmotion::ParameterStatus::{Done, Storage};
use narx_core::bus::narmotion::{FromDrive, MotorMode, ToDrive};
use narx_core::dictionary::{Parameters, number};
use narx_core::motor::State;
use narx_core::motor::guard::fault::FaultWord;
use narx_sim::flash::Tear;

/// Number of programs of the flash so far.
fn programs(device: &mut Device) -> u64 {
    device.storage.flash().counts().programs
}

#[test]
fn a_write_is_stored_within_two_seconds() {
    for (after, value) in [(500, 2000), (2000, 1234)] {
        let mut device = device();
        device.set(number::SPEED_RATE, 1234);
        device.run(after);
        assert_eq!(device.get(number::SPEED_RATE), 1234);
        assert_eq!(device.power_cut().get(number::SPEED_RATE), value, "power cut after {after} ms");
    }
}

/// A cut of an automatic store at any step leaves the old value or the new one, and the flash is healthy.
#[test]
fn a_power_cut_leaves_the_old_value_or_the_new_one() {
    let steps = {
        let mut device = device();
        device.set(number::SPEED_RATE, 1234);
        let before = device.storage.flash().steps();
        device.run(2000);
        device.storage.flash().steps() - before
    };
    assert!(steps > 100, "{steps}");
    let mut seen = [0, 0];
    for (cut, tear) in
        (0..steps).step_by(7).zip([Tear::Nothing, Tear::Partial, Tear::Garbage].into_iter().cycle())
    {
        let mut device = device();
        device.set(number::SPEED_RATE, 1234);
        device.run(900);
        device.storage.flash().cut_after(cut, tear);
        device.run(110);
        assert!(device.storage.flash().is_off(), "step {cut}");
        let (opened, _) = boot(device.storage.flash());
        assert_eq!(opened.faults, FaultWord::empty(), "step {cut}, {tear:?}");
        let value = opened.parameters.raw(number::SPEED_RATE);
        assert!([2000, 1234].contains(&value), "step {cut}, {tear:?}: {value}");
        seen[usize::from(value == 1234)] += 1;
    }
    assert!(seen[0] > 0 && seen[1] > 0, "{seen:?}");
}

/// Hundreds of writes are stored once a second, and writes of values that are already stored not at all.
#[test]
fn writes_are_stored_together_and_only_once() {
    let mut device = device();
    let idle = programs(&mut device);
    for _ in 0..50 {
        device.set(number::SPEED_RATE, 2000);
    }
    device.run(2000);
    assert_eq!(programs(&mut device), idle, "nothing has changed");
    let (before, start) = (device.stores, device.now);
    for value in 0..5000 {
        device.set(number::SPEED_RATE, 1000 + value);
        device.run(1);
    }
    let seconds = (device.now - start).div_ceil(10_000) as u32;
    device.run(2000);
    let stores = device.stores - before;
    assert!((seconds - 1..=seconds).contains(&stores), "{stores} stores in {seconds} s");
    assert_eq!(device.power_cut().get(number::SPEED_RATE), 5999);
}

/// A value that is changed and changed back is not stored.
#[test]
fn a_value_that_is_as_it_was_is_not_stored() {
    let mut device = device();
    let before = programs(&mut device);
    device.set(number::SPEED_RATE, 1234);
    device.set(number::SPEED_RATE, 2000);
    device.run(2000);
    assert_eq!(programs(&mut device), before);
}

#[test]
fn what_257_keeps_is_kept_by_257_alone() {
    let mut device = device();
    device.set(number::HV_CURRENT_OFFSET, 56);
    device.set(number::DEVICE_NUMBER, 9);
    device.run(3000);
    let mut device = device.reboot();
    assert_eq!((device.get(number::HV_CURRENT_OFFSET), device.get(number::DEVICE_NUMBER)), (0, 1));
    device.set(number::DEVICE_NUMBER, 9);
    assert_eq!(device.command(number::STORE_ONCE), Some(Done));
    device.send(ToDrive::RequestDeviceInfo);
    device.run(10);
    let number_of = |device: &Device| {
        device.received.iter().find_map(|message| match message {
            FromDrive::DeviceInfo { device_number, .. } => Some(*device_number),
            _ => None,
        })
    };
    assert_eq!(number_of(&device), Some(1), "it is taken at power-up, as the addresses are");
    let mut device = device.reboot();
    device.send(ToDrive::RequestDeviceInfo);
    device.run(10);
    assert_eq!(number_of(&device), Some(9));
}

/// With parameter 307 at 0 only 256 stores. The 0 itself lasts, with everything that was written before it.
#[test]
fn the_automatic_store_can_be_off() {
    let mut device = device();
    device.set(number::SPEED_RATE, 1234);
    device.set(number::AUTOMATIC_STORE, 0);
    device.run(50);
    device.set(number::SPEED_RATE, 1235);
    device.run(5000);
    let mut device = device.reboot();
    assert_eq!((device.get(number::AUTOMATIC_STORE), device.get(number::SPEED_RATE)), (0, 1234));
    device.set(number::SPEED_RATE, 1235);
    assert_eq!(device.command(number::STORE), Some(Done));
    device.set(number::SPEED_RATE, 1236);
    device.run(5000);
    let mut device = device.power_cut();
    assert_eq!(device.get(number::SPEED_RATE), 1235);
    device.set(number::SPEED_RATE, 1237);
    device.set(number::AUTOMATIC_STORE, 1);
    device.run(2000);
    assert_eq!(device.power_cut().get(number::SPEED_RATE), 1237);
}

#[test]
fn a_reboot_stores_first() {
    let mut device = device();
    device.set(number::SPEED_RATE, 1234);
    device.hold = true;
    device.send(ToDrive::Reboot);
    device.run(100);
    assert_eq!(device.node.poll_action(), None, "the flash has not answered");
    device.hold = false;
    assert_eq!(device.reboot().get(number::SPEED_RATE), 1234);
}

/// The automatic store does not interfere with commands: 256 is neither refused because of it nor delayed by
/// its second.
#[test]
fn a_command_goes_with_the_automatic_store() {
    let mut device = device();
    device.set(number::SPEED_RATE, 1234);
    device.hold = true;
    device.run(1100);
    assert_eq!(device.command(number::STORE), None, "it waits for the one that is under way");
    device.hold = false;
    assert_eq!(device.answer(number::STORE), Some((1, Done)));
    assert_eq!(device.command(number::STORE), Some(Storage), "those that are asked for are a second apart");
}

/// If the flash is lost, the values stay in force, and are stored when it is back.
#[test]
fn what_could_not_be_stored_is_stored_when_the_flash_is_back() {
    let mut device = device();
    device.set(number::SPEED_RATE, 1234);
    device.storage.flash().set_absent(true);
    device.run(2000);
    assert_eq!((device.state(), device.faults()), (State::Fault, FaultWord::STORE_ABSENT));
    assert_eq!(device.get(number::SPEED_RATE), 1234);
    device.storage.flash().set_absent(false);
    device.run(2000);
    device.request(MotorMode::Standby);
    device.run(20);
    assert_eq!(device.state(), State::Standby);
    assert_eq!(device.power_cut().get(number::SPEED_RATE), 1234);
}

/// With fault 30 at power-up, values that a master writes before the flash is there take precedence over the
/// flash's.
#[test]
fn a_flash_that_comes_late_leaves_what_has_been_written() {
    let mut chip = small(&set(7));
    chip.set_absent(true);
    let mut device = Device::booted(chip);
    device.set(number::SPEED_RATE, 1234);
    device.storage.flash().set_absent(false);
    device.run(3000);
    assert_eq!((device.get(number::SPEED_RATE), device.get(number::LOG_PERIOD)), (1234, 17));
    let stored = boot(device.storage.flash()).0.parameters;
    assert_eq!((stored.raw(number::SPEED_RATE), stored.raw(number::LOG_PERIOD)), (1234, 17));
}

/// A flash with a fault may hold the set of another board. The drive overwrites it only when a master
/// requests that.
#[test]
fn a_flash_with_a_fault_is_written_on_demand_alone() {
    let mut device = Device::booted(crate::support::blank(narx_sim::flash::KBYTE_512));
    assert_eq!(device.faults(), FaultWord::STORE_MISMATCH);
    let before = programs(&mut device);
    device.set(number::SPEED_RATE, 1234);
    device.run(5000);
    assert_eq!((programs(&mut device), device.faults()), (before, FaultWord::STORE_MISMATCH));
    assert_eq!(device.command(number::STORE), Some(Done));
    assert_eq!(device.power_cut().get(number::SPEED_RATE), 1234);
}

/// A restore is possible at any moment, and takes effect at the next reboot; device number and calibration
/// are kept.
#[test]
fn a_restore_is_in_force_after_the_reboot() {
    for driving in [false, true] {
        let mut device = device();
        device.set(number::HALL_ENABLE, 1);
        device.set(number::SPEED_RATE, 1234);
        device.set(number::HV_CURRENT_OFFSET, 56);
        device.set(number::DEVICE_NUMBER, 77);
        assert_eq!(device.command(number::STORE_ONCE), Some(Done));
        let mut device = device.reboot();
        if driving {
            device.request(MotorMode::Drive);
            device.run(10);
            assert_eq!(device.state(), State::HallClosedLoop);
        }
        let (state, refused) = (device.state(), device.get(number::REFUSED_FRAMES));
        device.send(ToDrive::RestoreFactory { serial: 76 });
        device.run(100);
        assert_eq!(device.get(number::REFUSED_FRAMES), refused + 1);
        assert_eq!(boot(device.storage.flash()).0.parameters.raw(number::SPEED_RATE), 1234);
        device.send(ToDrive::RestoreFactory { serial: 77 });
        device.run(100);
        assert_eq!((device.state(), device.get(number::SPEED_RATE)), (state, 1234), "what is in force stays");
        assert_eq!(device.get(number::REFUSED_FRAMES), refused + 1);
        let device = device.power_cut();
        assert_eq!((device.get(number::SPEED_RATE), device.get(number::HALL_ENABLE)), (2000, 0));
        assert_eq!((device.get(number::HV_CURRENT_OFFSET), device.get(number::DEVICE_NUMBER)), (56, 77));
    }
}

/// After a restore a write lasts as usual, and the rest of the set that is still in force does not.
#[test]
fn a_write_after_a_restore_lasts_alone() {
    for asked in [false, true] {
        let mut stored = set(7);
        stored.set(number::SLAVE_CAN_ADDRESS, Parameters::new().raw(number::SLAVE_CAN_ADDRESS)).unwrap();
        stored.set(number::SPEED_MAX_HES, 7000).unwrap();
        let mut device = Device::booted(small(&stored));
        device.send(ToDrive::RestoreFactory { serial: 100 });
        device.run(100);
        // One write that changes a value, and one that does not.
        device.set(number::SPEED_RATE, 1234);
        device.set(number::LOG_PERIOD, 17);
        if asked {
            assert_eq!(device.command(number::STORE), Some(Done));
        } else {
            device.run(2000);
        }
        assert_eq!(device.get(number::SPEED_MAX_HES), 7000);
        let stored = boot(device.storage.flash()).0.parameters;
        let mut expected = Parameters::new();
        for (number, raw) in [
            (number::SPEED_RATE, 1234),
            (number::LOG_PERIOD, 17),
            (number::DEVICE_NUMBER, 100),
            (number::HV_CURRENT_OFFSET, 7),
        ] {
            expected.set(number, raw).unwrap();
        }
        assert_eq!(stored, expected, "asked: {asked}");
    }
}
