//! The parameters in a few pages of the flash that the code runs from.
//!
//! ```text
//!  page 0              page 1              page 2              page 3
//!  | first           | its twin          | older or blank    | older or blank    |
//! ```
//!
//! Two pages hold the same words. A store appends the changed values and a commit to the first, and only then
//! copies them to its twin. If there is no room, or a word reads back wrong, everything in force is written
//! into the next page that is neither. So a power cut damages one page at most, a damaged page is made anew
//! from its twin, and pages are erased in turn. Nothing here waits: each [`step`](CodeFlash::step) erases one
//! page at most.

mod page;

use super::{FlashReply, FlashTask, Memory, Opened, Part, parameters::FORMAT};
use crate::dictionary::{Dictionary, PARAMETER_COUNT, Parameters, number::SOFTWARE_RELEASE};
use crate::motor::guard::fault::FaultWord;
use core::cmp::Ordering;
use embedded_storage::nor_flash::NorFlash;
use page::{COMMIT, HEAD, Page};

/// Two pages with the parameters, and one to move to.
const PAGES_MIN: u32 = 3;

/// An operation of the flash has failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Failed;

/// Serves a node's requests on the flash that the code runs from. There is no log: requests for it fail.
#[derive(Clone, Debug)]
pub struct CodeFlash<F> {
    flash: F,
    request: Option<FlashTask>,
    /// The flash was scanned, and is large enough.
    is_open: bool,
    /// The newest page that is whole.
    first: Option<Page>,
    /// The copy of the first page; its last words may still be missing.
    twin: Option<Page>,
    /// Count of the last store that was committed anywhere.
    count: u32,
    /// A stored value did not fit its parameter: the next store writes both parts.
    unfit: bool,
    /// Stage of the request.
    stage: Stage,
    /// Attempts that have failed in this stage.
    tries: u32,
    repaired: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    Begin,
    Copy,
}

/// The value that a page has for each row of the dictionary.
type Table = [Option<i32>; PARAMETER_COUNT];

impl<F> CodeFlash<F> {
    /// Makes the storage; the flash is not read before the first request, which is [`Request::Open`].
    pub const fn new(flash: F) -> Self {
        Self {
            flash,
            request: None,
            is_open: false,
            first: None,
            twin: None,
            count: 0,
            unfit: false,
            stage: Stage::Begin,
            tries: 0,
            repaired: false,
        }
    }

    /// Gives the flash back.
    pub fn into_flash(self) -> F {
        self.flash
    }

    /// The flash.
    pub const fn flash(&mut self) -> &mut F {
        &mut self.flash
    }

    /// Takes a request, which [`step`](Self::step) executes. One at a time, as a node sends them.
    pub fn begin(&mut self, request: FlashTask) {
        (self.request, self.stage, self.tries, self.repaired) = (Some(request), Stage::Begin, 0, false);
    }
}

impl<F: NorFlash> CodeFlash<F> {
    /// Continues the request by one page; returns a report once it is done.
    pub fn step(&mut self) -> Option<FlashReply> {
        let request = self.request.take()?;
        match self.advance(&request) {
            Ok(None) => {
                self.request = Some(request);
                None
            }
            Ok(report) => report,
            Err(Failed) => Some(self.failed(&request)),
        }
    }

    fn advance(&mut self, request: &FlashTask) -> Result<Option<FlashReply>, Failed> {
        match (request, self.stage) {
            (FlashTask::Open, Stage::Begin) => self.look()?,
            (FlashTask::Store(parameters, part), Stage::Begin) if self.is_open => {
                let is_written = self.write(parameters, *part).is_ok();
                self.go_on(is_written)?;
            }
            (FlashTask::Open | FlashTask::Store(..), Stage::Copy)
                if self.first.is_some() && self.is_alone() =>
            {
                let is_copied = self.copy().is_ok();
                self.go_on(is_copied)?;
                self.repaired = true;
            }
            (FlashTask::Open, Stage::Copy) => {
                return self.opened().map(|opened| Some(FlashReply::Opened(opened)));
            }
            (FlashTask::Store(..), Stage::Copy) => {
                return Ok(Some(FlashReply::Stored { done: true, log: Memory::default() }));
            }
            _ => return Err(Failed),
        }
        Ok(None)
    }

    /// Goes to the next stage, or prepares another attempt.
    fn go_on(&mut self, is_done: bool) -> Result<(), Failed> {
        self.tries = if is_done { 0 } else { self.tries + 1 };
        if is_done {
            self.stage = Stage::Copy;
        }
        if self.tries > pages(&self.flash) { Err(Failed) } else { Ok(()) }
    }

    fn failed(&mut self, request: &FlashTask) -> FlashReply {
        let log = Memory::default();
        match request {
            FlashTask::Open => {
                self.is_open = false;
                FlashReply::Opened(Opened {
                    parameters: Parameters::new(),
                    faults: FaultWord::STORE_ABSENT,
                    repaired: false,
                    log,
                })
            }
            FlashTask::Store(..) => FlashReply::Stored { done: false, log },
            FlashTask::Append(_) | FlashTask::Erase => FlashReply::Log { done: false, memory: log },
            FlashTask::Read(_) => FlashReply::Record(None),
        }
    }

    /// Finds the newest page and its twin. If no whole page has the newest commit, the last store is lost,
    /// and no older page is used in its place.
    fn look(&mut self) -> Result<(), Failed> {
        let room = page::words::<F>() as usize;
        if pages(&self.flash) < PAGES_MIN || room < Dictionary::STORED_COUNT + 2 {
            return Err(Failed);
        }
        (self.first, self.twin, self.count, self.stage) = (None, None, 0, Stage::Copy);
        for index in 0..pages(&self.flash) {
            let page = page::scan(&mut self.flash, index, &mut |_, _| {})?;
            let Some(count) = page.count else { continue };
            match (count.wrapping_sub(self.count) as i32).cmp(&0) {
                Ordering::Greater => {
                    (self.first, self.twin) = (Some(page).filter(|page| page.is_whole), None);
                    self.count = count;
                }
                Ordering::Equal if page.is_whole && self.first.is_none() => self.first = Some(page),
                Ordering::Equal if page.is_whole => {
                    self.twin =
                        Some(page).filter(|page| self.first.is_some_and(|first| page.is_equal(&first)));
                }
                _ => {}
            }
        }
        self.is_open = true;
        Ok(())
    }

    /// Returns whether the first page has no equal twin.
    fn is_alone(&self) -> bool {
        !matches!((self.first, self.twin), (Some(first), Some(twin)) if twin.is_equal(&first))
    }

    fn opened(&mut self) -> Result<Opened, Failed> {
        let mut opened = Opened {
            parameters: Parameters::new(),
            faults: FaultWord::empty(),
            repaired: self.repaired,
            log: Memory::default(),
        };
        let table = self.table()?;
        let mut fits = self.first.is_none_or(|page| page.form <= FORMAT);
        for (row, value) in Dictionary::rows().zip(table) {
            if let Some(value) = value.filter(|_| row.is_stored()) {
                fits &= opened.parameters.set(row.number, value).is_ok();
            }
        }
        self.unfit = !fits;
        opened.faults.set(FaultWord::STORE_VERSION, !fits);
        opened.faults.set(FaultWord::STORE_MISMATCH, self.first.is_none());
        Ok(opened)
    }

    /// Reads the values of the first page; none if its format is newer than this firmware's.
    fn table(&mut self) -> Result<Table, Failed> {
        let mut table = [None; PARAMETER_COUNT];
        if let Some(first) = self.first.filter(|page| page.form <= FORMAT) {
            page::scan(&mut self.flash, first.index, &mut |number, value| {
                if let Some(place) = Dictionary::index(number).and_then(|index| table.get_mut(index)) {
                    *place = Some(value);
                }
            })?;
        }
        Ok(table)
    }

    /// Appends the changed values to the first page. Writes everything in force into the next page if that
    /// has failed, for example for lack of room, or if there is no first page of this format.
    fn write(&mut self, parameters: &Parameters, part: Part) -> Result<(), Failed> {
        let table = self.table()?;
        let both = self.first.is_none() || self.unfit;
        let (index, from) = match self.first {
            Some(first) if self.tries == 0 && first.form == FORMAT => (first.index, first.end),
            _ => (self.begin_page()?, 1),
        };
        let is_new = from == 1;
        if is_new {
            let release = parameters.raw(SOFTWARE_RELEASE) as u16;
            page::put(&mut self.flash, index, 0, HEAD, i32::from(FORMAT) << 16 | i32::from(release))?;
        }
        let mut place = from;
        for ((row, raw), kept) in parameters.iter().zip(table) {
            let is_given = part.contains(row) || both && row.is_stored();
            let value = if is_given { Some(raw) } else { kept };
            if let Some(value) = value.filter(|value| is_new || kept != Some(*value)) {
                page::put(&mut self.flash, index, place, row.number, value)?;
                place += 1;
            }
        }
        if place == from {
            return Ok(());
        }
        let count = self.count.wrapping_add(1);
        page::put(&mut self.flash, index, place, COMMIT, count as i32)?;
        let page = page::scan(&mut self.flash, index, &mut |_, _| {})?;
        if !page.is_whole || page.count != Some(count) {
            return Err(Failed);
        }
        (self.first, self.count, self.unfit) = (Some(page), count, false);
        if is_new {
            self.twin = None;
        }
        Ok(())
    }

    /// Makes the twin equal to the first page: copies the words that it lacks, or all of them into the next
    /// page.
    fn copy(&mut self) -> Result<(), Failed> {
        let first = self.first.ok_or(Failed)?;
        let (index, from) = match self.twin.take() {
            Some(twin) => (twin.index, twin.end),
            None => (self.begin_page()?, 0),
        };
        for place in from..first.end {
            let word = page::read(&mut self.flash, first.index, place)?;
            page::write(&mut self.flash, index, place, word)?;
        }
        let page = page::scan(&mut self.flash, index, &mut |_, _| {})?;
        self.twin = Some(page).filter(|page| page.is_whole && page.is_equal(&first));
        if self.twin.is_some() { Ok(()) } else { Err(Failed) }
    }

    /// Erases the next page behind the first that is not the twin; later attempts take later pages.
    fn begin_page(&mut self) -> Result<u32, Failed> {
        let pages = pages(&self.flash);
        let mut index = self.first.map_or(pages - 1, |first| first.index);
        let mut others = self.tries.saturating_sub(1);
        for _ in 0..pages {
            index = (index + 1) % pages;
            let is_used = [self.first, self.twin].iter().flatten().any(|page| page.index == index);
            if !is_used && others == 0 {
                return page::erase(&mut self.flash, index).map(|()| index);
            }
            others -= u32::from(!is_used);
        }
        Err(Failed)
    }
}

fn pages<F: NorFlash>(flash: &F) -> u32 {
    (flash.capacity() / F::ERASE_SIZE) as u32
}
