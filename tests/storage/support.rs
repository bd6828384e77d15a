//! Chips, drives' storages on them, and futures that never wait: the simulated flash answers at once and
//! reports the time that it took.

use core::pin::pin;
use core::task::{Context, Poll, Waker};
use narx_core::dictionary::{Parameters, number};
use narx_core::storage::{FlashReply, FlashTask, Opened, Part, Storage};
use narx_sim::flash::{Flash, KBYTE_512, Sparse};

pub(crate) type Chip = Flash<Sparse>;

/// Result of a future that never waits.
pub(crate) fn now<T>(future: impl Future<Output = T>) -> T {
    match pin!(future).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(answer) => answer,
        Poll::Pending => panic!("the simulated flash never waits"),
    }
}

pub(crate) fn blank(identification: [u8; 3]) -> Chip {
    Flash::new(identification, Sparse::new(), 1)
}

/// Parameters whose two parts differ from the factory's, and from those of another `variant`.
pub(crate) fn set(variant: i32) -> Parameters {
    let mut parameters = Parameters::new();
    for (number, raw) in [
        (number::SPEED_RATE, 1000 + variant),
        (number::HV_CURRENT_OFFSET, variant % 1000),
        (number::SLAVE_CAN_ADDRESS, variant & 0x7F),
        (number::LOG_PERIOD, 10 + variant),
        (number::DEVICE_NUMBER, 100),
    ] {
        parameters.set(number, raw).unwrap();
    }
    parameters
}

pub(crate) fn open(storage: &mut Storage<Chip>) -> Opened {
    match now(storage.execute(FlashTask::Open)) {
        FlashReply::Opened(opened) => opened,
        other => panic!("{other:?}"),
    }
}

pub(crate) fn store(storage: &mut Storage<Chip>, parameters: &Parameters, part: Part) -> bool {
    match now(storage.execute(FlashTask::Store(parameters.clone(), part))) {
        FlashReply::Stored { done, .. } => done,
        other => panic!("{other:?}"),
    }
}

/// A drive's flash with a stored set.
pub(crate) fn formatted(identification: [u8; 3], parameters: &Parameters) -> Chip {
    let mut storage = Storage::new(blank(identification));
    assert!(now(storage.format(parameters)));
    storage.into_flash()
}

/// The smallest drive: every byte of its flash can be checked.
pub(crate) fn small(parameters: &Parameters) -> Chip {
    formatted(KBYTE_512, parameters)
}

/// State that a drive finds at power-up.
pub(crate) fn boot(chip: &Chip) -> (Opened, Chip) {
    let mut storage = Storage::new(chip.clone());
    storage.flash().restore_power();
    let opened = open(&mut storage);
    (opened, storage.into_flash())
}
