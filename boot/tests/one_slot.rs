//! One slot: the drive makes way for its bootloader, which receives over the bus. Whatever fails, it receives
//! again.

use crate::support::{Flash, HARDWARE, Hasty, NEW, OLD, PAGE, version};
use crate::wire::{Programmed, Wire};
use embedded_storage::nor_flash::ReadNorFlash;
use narx_boot::one_slot::{Addresses, Entry, Step};
use narx_boot::{Inside, Map, MapError, OneSlot, Server, Slot, SlotError, Verdict};
use narx_core::bus::Frame;
use narx_core::bus::narmotion::update::{UpdateCode, UpdateRequest};
use narx_core::bus::narmotion::{Addresses as Factory, MotorMode, RequestWord, ToDrive};
use narx_core::master::{Image, UpdateError};
use narx_core::motor::{Board, State, Status};
use narx_core::node::update::Loader;
use narx_core::node::{Action, Identity, Node};
use narx_sim::flash::{Sparse, Tear};
use narx_sim::random::Random;

const MAP: Map = Map::stacked([PAGE as u32, 4 * PAGE as u32, 0, PAGE as u32, PAGE as u32]);
const ADDRESSES: Addresses = [Factory::FACTORY.drive, Factory::FACTORY.master];

/// Program that runs on the board.
enum Program {
    Drive(Box<Node>, Server<Inside<Flash>>),
    Loader(Box<Loader>, Server<OneSlot<Flash>>),
    /// Neither: the flash has no power.
    Nothing(OneSlot<Flash>),
}

/// A board with one slot, from reset to reset.
struct Device {
    /// Empty while it boots.
    program: Option<Program>,
    milliseconds: u64,
}

impl Device {
    fn new(flash: Flash) -> Self {
        let mut device = Self { program: None, milliseconds: 0 };
        device.power_up(flash);
        device
    }

    /// With this image in the slot, as a debugger loads it.
    fn with(image: &[u8]) -> Self {
        let mut flash = Flash::new(Sparse::new(), 7 * PAGE as u32, 1);
        flash.load(MAP.active.start, image);
        Self::new(flash)
    }

    fn power_up(&mut self, flash: Flash) {
        let mut slot = OneSlot::new(flash, MAP, HARDWARE).unwrap();
        self.program = Some(match slot.boot(Hasty) {
            Err(_) => {
                assert!(slot.flash().is_off());
                Program::Nothing(slot)
            }
            Ok(Entry::Run(_)) => {
                let mut server = Server::new(Inside { slot, addresses: ADDRESSES });
                let mut node = Node::new(Identity::default(), Board::BENCH);
                node.attach_update(&server.slots().unwrap());
                let status = Status { state: State::Standby, standstill: true, ..Status::default() };
                node.handle_status(status);
                Program::Drive(Box::new(node), server)
            }
            Ok(Entry::Receive) => Program::Loader(Box::new(slot.loader().unwrap()), Server::new(slot)),
        });
    }

    fn into_flash(self) -> Flash {
        match self.program.unwrap() {
            Program::Drive(_, server) => server.into_slot().slot,
            Program::Loader(_, server) => server.into_slot(),
            Program::Nothing(slot) => slot,
        }
        .into_flash()
    }

    fn flash(&mut self) -> &mut Flash {
        match self.program.as_mut().unwrap() {
            Program::Drive(_, server) => server.slot().slot.flash(),
            Program::Loader(_, server) => server.slot().flash(),
            Program::Nothing(slot) => slot.flash(),
        }
    }

    const fn is_loader(&self) -> bool {
        matches!(self.program, Some(Program::Loader(..)))
    }

    fn node(&mut self) -> &mut Node {
        match &mut self.program {
            Some(Program::Drive(node, _)) => node,
            _ => panic!("the bootloader runs"),
        }
    }
}

impl Programmed for Device {
    fn handle_frame(&mut self, frame: &Frame) {
        match self.program.as_mut().unwrap() {
            Program::Drive(node, _) => node.handle_frame(frame),
            Program::Loader(loader, _) => loader.handle_frame(frame, self.milliseconds),
            Program::Nothing(_) => {}
        }
    }

    fn poll_frame(&mut self) -> Option<Frame> {
        match self.program.as_mut().unwrap() {
            Program::Drive(node, _) => node.poll_frame(),
            Program::Loader(loader, _) => loader.poll_frame(),
            Program::Nothing(_) => None,
        }
    }

    fn pass(&mut self) -> bool {
        self.milliseconds += 1;
        match self.program.as_mut().unwrap() {
            Program::Drive(node, server) => {
                node.poll(10 * self.milliseconds);
                if let Some(task) = node.poll_update() {
                    let reply = server.execute(&task);
                    node.handle_update(reply);
                }
                node.poll_action() == Some(Action::Reboot)
            }
            Program::Loader(loader, server) => {
                if let Some(task) = loader.poll_task(self.milliseconds) {
                    loader.handle_reply(server.execute(&task), self.milliseconds);
                }
                loader.is_over()
            }
            Program::Nothing(_) => false,
        }
    }

    fn reboot(&mut self) {
        let flash = Self { program: self.program.take(), milliseconds: 0 }.into_flash();
        self.power_up(flash);
    }
}

fn wire(device: Device, image: Vec<u8>) -> Wire<Device> {
    let mut wire = Wire::to(device, image);
    (0..100).for_each(|_| wire.step());
    wire
}

/// The version that the device runs; `None` if it is the bootloader.
fn running(device: &mut Device) -> Option<narx_boot::Version> {
    match device.program.as_mut().unwrap() {
        Program::Drive(_, server) => Some(server.slot().slot.header().unwrap().unwrap().version),
        Program::Loader(..) | Program::Nothing(_) => None,
    }
}

#[test]
fn a_master_programs_it_as_a_drive_of_two_slots() {
    for loss in [0, 50, 200] {
        let image = Hasty::image(NEW, 1528);
        let mut wire = wire(Device::with(&Hasty::image(OLD, 1000)), image.clone());
        wire.loss = loss;
        wire.begin();
        assert_eq!(wire.finish(60), Some(Ok(())), "{loss} of 1000 frames lost");
        // It was confirmed: a restart changes nothing.
        wire.drive.reboot();
        assert_eq!(running(&mut wire.drive), Some(NEW));
    }
}

/// Everything that ends an update leaves a bootloader that takes the next one.
#[test]
fn it_receives_again_whatever_has_ended_the_first_update() {
    let old = Hasty::image(OLD, 1000);
    let mut altered = Hasty::image(NEW, 1000);
    altered[1000] ^= 1;
    let signature = Err(UpdateError::Refused(UpdateCode::Signature));
    let mut refused = wire(Device::with(&old), altered);
    refused.begin();
    assert_eq!(refused.finish(60), Some(signature));

    let mut silent = wire(Device::with(&old), Hasty::image(NEW, 1528));
    silent.begin();
    (0..200).for_each(|_| silent.step());
    silent.loss = 1000;
    assert_eq!(silent.finish(20), Some(Err(UpdateError::Silent)));

    // A program that does not come up to be confirmed.
    let mut reverted = wire(Device::with(&old), Hasty::image(NEW, 1000));
    reverted.begin();
    while reverted.drive.is_loader() || running(&mut reverted.drive) == Some(OLD) {
        reverted.step();
    }
    reverted.drive.reboot();
    assert!(reverted.drive.is_loader());
    assert_eq!(reverted.finish(60), Some(Err(UpdateError::Refused(UpdateCode::Reverted))));

    for mut again in [refused, silent, reverted] {
        assert!(again.drive.is_loader());
        again.loss = 0;
        again.bytes = Hasty::image(NEW, 1528);
        again.begin();
        assert_eq!(again.finish(60), Some(Ok(())));
        assert_eq!(running(&mut again.drive), Some(NEW));
    }
}

/// The version that ran last sets the floor, even when nothing of it is left.
#[test]
fn an_older_image_is_refused_by_the_drive_and_by_the_bootloader() {
    let older = version(1, 2, 3, 3);
    let image = Hasty::image(older, 1000);
    let refused = UpdateError::Older { image: older.into(), running: OLD.into() };
    let mut wire = wire(Device::with(&Hasty::image(OLD, 1000)), image.clone());
    wire.master.update(Image::new(HARDWARE, older.into(), &image)).unwrap();
    assert_eq!(wire.finish(5), Some(Err(refused)));
    // The drive has left; the slot is half erased.
    wire.bytes = Hasty::image(NEW, 1000);
    wire.begin();
    (0..100).for_each(|_| wire.step());
    wire.master.abort_update();
    assert_eq!(wire.finish(5), Some(Err(UpdateError::Aborted)));
    assert!(wire.drive.is_loader());
    wire.bytes = image.clone();
    wire.master.update(Image::new(HARDWARE, older.into(), &image)).unwrap();
    assert_eq!(wire.finish(5), Some(Err(refused)));
    // A master that does not ask is refused at the end, and a boot does not enter such an image either.
    let flash = wire.drive.into_flash();
    let mut slot = OneSlot::new(flash, MAP, HARDWARE).unwrap();
    slot.begin(ADDRESSES).unwrap();
    let fill = |slot: &mut OneSlot<Flash>, image: &[u8]| {
        (0..4).for_each(|page| slot.erase(page * PAGE as u32).unwrap());
        slot.write(0, image).unwrap();
    };
    fill(&mut slot, &image);
    assert!(matches!(slot.complete(image.len() as u32), Err(SlotError::Image(_))));
    let new = Hasty::image(NEW, 1000);
    fill(&mut slot, &new);
    slot.complete(new.len() as u32).unwrap();
    fill(&mut slot, &image);
    assert_eq!(slot.boot(Hasty), Ok(Entry::Receive));
    let verdict = slot.condition().unwrap().verdict;
    assert_eq!(verdict, Some(Verdict::Refused(narx_boot::Refused::Older)));
}

/// Nothing starts in the time between the request and the restart.
#[test]
fn a_drive_that_leaves_does_not_start() {
    let mut device = Device::with(&Hasty::image(OLD, 1000));
    let begin = UpdateRequest::Begin { length: 1512, hardware: HARDWARE };
    device.handle_frame(&ToDrive::Update(begin).encode(Factory::FACTORY));
    while device.node().poll_event().is_some() {}
    let start = ToDrive::RequestWord(RequestWord { mode: MotorMode::Drive }).encode(Factory::FACTORY);
    device.handle_frame(&start);
    assert_eq!(device.node().poll_event(), None);
    let mut pass = || {
        while device.poll_frame().is_some() {}
        device.pass()
    };
    assert!((0..20).any(|_| pass()));
    device.reboot();
    assert!(device.is_loader());
}

/// The bootloader answers at the addresses that the drive had, and to nobody else.
#[test]
fn it_receives_at_the_addresses_of_the_drive() {
    let mut slot = OneSlot::new(Device::with(&Hasty::image(OLD, 1000)).into_flash(), MAP, HARDWARE).unwrap();
    slot.leave([7, 9]).unwrap();
    assert_eq!(slot.boot(Hasty), Ok(Entry::Receive));
    let mut loader = slot.loader().unwrap();
    for (addresses, answers) in [
        (Factory { drive: 7, master: 9 }, true),
        (Factory::FACTORY, false),
        (Factory { drive: 7, master: 8 }, false),
    ] {
        loader.handle_frame(&ToDrive::Update(UpdateRequest::Status).encode(addresses), 0);
        assert_eq!(loader.poll_frame().is_some(), answers, "{addresses:?}");
    }
}

/// The power fails in every step of an update. The board runs a whole image, or its bootloader takes the next
/// update; never neither.
fn survive(tear: Tear) {
    let (old, new) = (Hasty::image(OLD, 1320), Hasty::image(NEW, 1528));
    let fresh = Device::with(&old).into_flash();
    let steps = {
        let mut wire = wire(Device::new(fresh.clone()), new.clone());
        wire.begin();
        assert_eq!(wire.finish(60), Some(Ok(())));
        wire.drive.flash().steps()
    };
    // Four pages and their words, records, and the page of these.
    assert!(steps > 4 + 255 + 16, "{steps}");
    let mut random = Random::new(steps);
    for step in 0..steps {
        let mut flash = fresh.clone();
        flash.cut_after(step, tear);
        let mut cut = wire(Device::new(flash), new.clone());
        cut.begin();
        while !cut.drive.flash().is_off() {
            cut.step();
        }
        let mut flash = cut.drive.into_flash();
        flash.restore_power();
        let mut back = Device::new(flash);
        if let Some(version) = running(&mut back) {
            let image = if version == OLD { &old } else { &new };
            let mut bytes = vec![0; image.len()];
            ReadNorFlash::read(back.flash(), MAP.active.start, &mut bytes).unwrap();
            assert!(bytes == *image, "step {step}: not all of {version:?}");
        }
        // A trial has to end before.
        back.reboot();
        let mut again = wire(back, new.clone());
        again.loss = random.bits() % 100;
        again.begin();
        assert_eq!(again.finish(60), Some(Ok(())), "step {step} of {steps}, {tear:?}");
    }
}

#[test]
fn cuts_that_leave_what_was_there() {
    survive(Tear::Nothing);
}

#[test]
fn cuts_that_leave_a_part() {
    survive(Tear::Partial);
}

#[test]
fn cuts_that_leave_garbage() {
    survive(Tear::Garbage);
}

/// A record that is torn behind any of its words, or has lost a bit, says nothing. (Its last word is that of
/// erased flash.)
#[test]
fn a_damaged_record_is_none() {
    const RECORD: usize = 32;
    let mut slot = OneSlot::new(Device::with(&Hasty::image(OLD, 1000)).into_flash(), MAP, HARDWARE).unwrap();
    slot.leave([7, 9]).unwrap();
    // Behind the floor stands the record of the leaving.
    let place = MAP.state.start + RECORD as u32;
    let mut whole = [0; RECORD];
    ReadNorFlash::read(slot.flash(), place, &mut whole).unwrap();
    let torn = (0..RECORD - 8).step_by(8).map(|kept| {
        let mut bytes = [0xFF; RECORD];
        bytes[..kept].copy_from_slice(&whole[..kept]);
        bytes
    });
    let flipped = (0..8 * RECORD).map(|bit| {
        let mut bytes = whole;
        bytes[bit / 8] ^= 1 << (bit % 8);
        bytes
    });
    for bytes in torn.chain(flipped) {
        slot.flash().load(place, &bytes);
        let condition = slot.condition().unwrap();
        assert_eq!((condition.step, condition.addresses), (Step::Run, None), "{bytes:02X?}");
        assert_eq!(condition.floor, Some(OLD));
    }
}

/// More attempts than the page of records has room for.
#[test]
fn records_begin_anew_when_their_page_is_full() {
    let mut slot = OneSlot::new(Device::with(&Hasty::image(OLD, 1000)).into_flash(), MAP, HARDWARE).unwrap();
    slot.leave([7, 9]).unwrap();
    for _ in 0..50 {
        slot.begin([7, 9]).unwrap();
        let condition = slot.condition().unwrap();
        assert_eq!(
            (condition.step, condition.floor, condition.addresses),
            (Step::Receive, Some(OLD), Some([7, 9]))
        );
    }
}

#[test]
fn a_map_has_one_slot_or_two() {
    let flash = Device::with(&[]).into_flash();
    assert_eq!(Slot::new(flash.clone(), MAP, HARDWARE).map(drop), Err(MapError::Dfu));
    let two = Map::stacked([0, PAGE as u32, 2 * PAGE as u32, PAGE as u32, 0]);
    assert_eq!(OneSlot::new(flash, two, HARDWARE).map(drop), Err(MapError::Dfu));
}
