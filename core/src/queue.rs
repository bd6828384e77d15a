//! The ends of a `heapless` queue, without a way to panic.
//!
//! An end sees its queue as a slice and divides by its length, which the compiler cannot know to be other than zero: every use would carry
//! a division by zero and the text that reports it. Here an end without a place is empty and full, and nothing is left of the rest.

use heapless::spsc::{Consumer, Producer};

/// The oldest item.
#[inline]
pub fn dequeue<T>(queue: &mut Consumer<'_, T>) -> Option<T> {
    if has_places(queue.capacity()) { queue.dequeue() } else { None }
}

/// Adds an item; one that finds no room comes back.
///
/// # Errors
/// The queue is full.
#[inline]
pub fn enqueue<T>(queue: &mut Producer<'_, T>, item: T) -> Result<(), T> {
    if has_places(queue.capacity()) { queue.enqueue(item) } else { Err(item) }
}

/// Whether [`enqueue`] has room.
#[inline]
pub fn has_room<T>(queue: &Producer<'_, T>) -> bool {
    has_places(queue.capacity()) && queue.ready()
}

/// A capacity is one less than the places.
const fn has_places(capacity: usize) -> bool {
    capacity != usize::MAX
}
