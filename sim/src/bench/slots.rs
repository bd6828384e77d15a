//! The slots of the virtual drive and its bootloader: signatures, swaps and reverts are those of a board. The
//! program in an image is not run; the drive takes its version and stays what it is.

use super::BenchNode;
use crate::flash::Sparse;
use crate::internal_flash::InternalFlash;
use narx_boot::sign::SecretKey;
use narx_boot::{Board, Header, Map, Server, Slot, Version, boot, hardware, key};
use narx_core::node::Identity;
use narx_core::node::update::{SlotReply, Slots as Attached};

/// Two slots of 50 KiB.
const MAP: Map = Map::stacked([16 << 10, 50 << 10, 52 << 10, 2 << 10, 8 << 10]);
const CAPACITY: u32 = 128 << 10;
const BOARD: Board = Board { hardware: hardware::BENCH, key: key::TEST_ONLY };
/// Body of the image that the drive leaves the factory with.
const PROGRAM: &[u8] = b"the program of the bench is not in here.";

type Flash = InternalFlash<Sparse>;

/// Slots, bootloader and what serves the node.
#[derive(Clone, Debug)]
pub(crate) struct Slots {
    server: Server<Slot<Flash>>,
    /// The factory image stands in the active slot: signing takes its time, and most drives never see an
    /// update.
    is_filled: bool,
    /// The drive's own version.
    version: Version,
    /// While the flash is busy: time at which it has finished, ns, and its report then.
    report: Option<(u64, SlotReply)>,
}

impl Slots {
    pub(crate) fn new(identity: &Identity) -> Self {
        let slot = Slot::new(InternalFlash::new(Sparse::new(), CAPACITY, 0), MAP, BOARD.hardware);
        #[allow(clippy::expect_used, reason = "both are constants")]
        let slot = slot.expect("the map fits the flash");
        let [major, minor] = identity.software_release.to_be_bytes();
        let version = Version { major, minor, patch: 0, build: identity.build_number };
        Self { server: Server::new(slot), is_filled: false, version, report: None }
    }

    /// Does the work of the bootloader at a reboot.
    pub(crate) fn boot(&mut self) {
        self.report = None;
        if !self.is_filled {
            return;
        }
        let flash = self.server.slot().flash();
        // Which image runs, the node is told when it is attached.
        let _ = boot(flash, &MAP, &BOARD);
        // The bench's drive is back at once.
        self.server.slot().flash().take_busy();
    }

    /// Tells the node its slots at power-up.
    pub(crate) fn attach(&mut self, node: &mut BenchNode) {
        // A flash that has its power can be read.
        let Ok(slots) = self.server.slots() else { return };
        let running = if self.is_filled { slots.running } else { self.version.into() };
        node.attach_update(&Attached { running, ..slots });
    }

    /// Lets the flash do what the node asks for; what it has done is told when a flash would be ready.
    pub(crate) fn serve(&mut self, node: &mut BenchNode, now: u64) {
        if let Some((_, report)) = self.report.take_if(|(due, _)| *due <= now) {
            node.handle_update(report);
        }
        if self.report.is_none()
            && let Some(request) = node.poll_update()
        {
            self.fill();
            let report = self.server.execute(&request);
            let busy = self.server.slot().flash().take_busy();
            self.report = Some((now + busy, report));
        }
    }

    /// The flash, to look at and to break.
    pub(crate) fn flash(&mut self) -> &mut Flash {
        self.fill();
        self.server.slot().flash()
    }

    fn fill(&mut self) {
        if core::mem::replace(&mut self.is_filled, true) {
            return;
        }
        let header = Header { hardware: BOARD.hardware, version: self.version, length: 0 };
        let header = SecretKey::TEST_ONLY.sign(header, PROGRAM);
        let flash = self.server.slot().flash();
        flash.load(MAP.active.start, &header);
        flash.load(MAP.entry(), PROGRAM);
    }
}
