//! Maps that a flash can have.

use crate::support::{Flash, MAP, PAGE};
use narx_boot::{Map, MapError};
use narx_sim::flash::Sparse;
use narx_sim::internal_flash::InternalFlash;

#[test]
fn the_st_board_has_its_map() {
    let flash: InternalFlash<Sparse> = InternalFlash::new(Sparse::new(), 128 << 10, 0);
    let map = Map::B_G431B_ESC1;
    assert_eq!(map.check(&flash), Ok(()));
    assert_eq!((map.parameters.end, map.room()), (128 << 10, 96 << 10));
    // The vector table is behind the header, and where the core takes one.
    assert_eq!((map.entry(), map.entry() % 512), ((22 << 10) + 512, 0));
}

#[test]
fn maps_that_cannot_be() {
    let flash = Flash::new(Sparse::new(), 12 * PAGE as u32, 0);
    let page = PAGE as u32;
    assert_eq!(MAP.check(&flash), Ok(()));
    let cases: [(Map, MapError); 7] = [
        (Map { active: page + 8..5 * page, ..MAP }, MapError::Range),
        (Map { active: page..page, ..MAP }, MapError::Range),
        (Map { active: 0..5 * page, ..MAP }, MapError::Range),
        (Map { parameters: 9 * page..11 * page, ..MAP }, MapError::Range),
        (Map { parameters: 11 * page..13 * page, ..MAP }, MapError::Capacity),
        (Map::stacked([page, 4 * page, 4 * page, page, 0]), MapError::Dfu),
        (Map::stacked([page, 4 * page, 6 * page, page, 0]), MapError::Dfu),
    ];
    for (map, error) in cases {
        assert_eq!(map.check(&flash), Err(error), "{map:?}");
    }
    // Seventeen pages want 71 words of state, and a page has 64.
    let large = Flash::new(Sparse::new(), 64 * page, 0);
    let lengths = [page, 17 * page, 18 * page, page, 0];
    assert_eq!(Map::stacked(lengths).check(&large), Err(MapError::State));
    let lengths = [page, 15 * page, 16 * page, page, 0];
    assert_eq!(Map::stacked(lengths).check(&large), Ok(()));
}
