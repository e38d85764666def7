//! How much memory an instance takes.

use super::fixture::{Importer, JENKINS, VALANIS};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

thread_local! {
    /// Bytes that this thread has taken and not given back.
    static TAKEN: Cell<isize> = const { Cell::new(0) };
}

struct Counted;

fn count(bytes: isize) {
    TAKEN.set(TAKEN.get() + bytes);
}

// SAFETY: the system's allocator, which is asked for the same. (The default `realloc` comes to the other two.)
unsafe impl GlobalAlloc for Counted {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(layout.size().cast_signed());
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        count(-layout.size().cast_signed());
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static COUNTED: Counted = Counted;

#[test]
fn a_contact_takes_less_than_a_kilobyte_and_gives_all_of_it_back() {
    for model in [JENKINS, VALANIS] {
        let importer = Importer::new(model);
        // The model, which all instances share.
        drop(importer.running());
        let before = TAKEN.get();
        let running = importer.running();
        let taken = TAKEN.get() - before;
        assert!((400..1000).contains(&taken), "{taken} bytes");
        drop(running);
        assert_eq!(TAKEN.get(), before);
    }
}
