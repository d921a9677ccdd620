//! The window as it looks.

mod common;

use common::{Begin, Desk};

fn keep(desk: &mut Desk, name: &str) {
    let picture = desk.window.render().expect("a device to draw windows with");
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR"));
    picture
        .save(folder.join(format!("{name}.png")))
        .expect("a file");
}

#[test]
fn the_window_shows_the_scene() {
    let mut desk = Desk::new(Begin {
        is_drawn: true,
        ..Begin::default()
    });
    desk.settle();
    keep(&mut desk, "window");
}
