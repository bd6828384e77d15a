//! The ends of a `heapless` queue, without a way to panic.
//!
//! An end sees its queue as a slice and divides by its length. The compiler cannot know that the length is
//! not zero, so every use would carry a check for a division by zero and the text that reports it. Here a
//! queue without places counts as both empty and full, and the check disappears.

use heapless::spsc::{Consumer, Producer};

/// The oldest item.
#[inline]
pub fn dequeue<T>(queue: &mut Consumer<'_, T>) -> Option<T> {
    if has_places(queue.capacity()) { queue.dequeue() } else { None }
}

/// Adds an item, or returns it if there is no room.
///
/// # Errors
/// The queue is full.
#[inline]
pub fn enqueue<T>(queue: &mut Producer<'_, T>, item: T) -> Result<(), T> {
    if has_places(queue.capacity()) { queue.enqueue(item) } else { Err(item) }
}

/// Returns whether [`enqueue`] has room.
#[inline]
pub fn has_room<T>(queue: &Producer<'_, T>) -> bool {
    has_places(queue.capacity()) && queue.ready()
}

/// A capacity is one less than the places.
const fn has_places(capacity: usize) -> bool {
    capacity != usize::MAX
}
