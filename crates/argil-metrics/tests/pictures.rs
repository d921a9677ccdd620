//! Compares image measures with SciPy, scikit-image and the authors' FLIP (`data/reference.py`), on images that
//! Argil rendered.

use argil_metrics::{Rgb8Image, differing_pixels, flip, laplacian, psnr, ssim};
use serde_json::Value;
use std::path::PathBuf;

fn data(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("tests/data")
        .join(name)
}

fn picture(name: &str) -> Rgb8Image {
    let rgb = image::open(data(name)).expect("a picture").to_rgb8();
    Rgb8Image::new(rgb.dimensions().into(), rgb.into_raw()).expect("a picture")
}

fn reference() -> Vec<Value> {
    let text = std::fs::read_to_string(data("reference.json")).expect("numbers");
    serde_json::from_str(&text).expect("JSON")
}

fn number(case: &Value, key: &str) -> f64 {
    case[key]
        .as_f64()
        .unwrap_or_else(|| panic!("{key} of {case}"))
}

#[test]
fn measures_agree_with_independent_ones() {
    let cases = reference();
    assert_eq!(cases.len(), 2);
    for case in &cases {
        let [a, b] = ["a", "b"].map(|key| picture(case[key].as_str().expect("a name")));
        let found = psnr(&a, &b).expect("one size");
        assert!((found - number(case, "psnr_db")).abs() < 1e-9, "{found}");
        let found = ssim(&a, &b).expect("one size");
        assert!((found - number(case, "ssim")).abs() < 1e-5, "{found}");
        let found = flip::flip(&a, &b, flip::PIXELS_PER_DEGREE).expect("one size");
        assert_eq!(found.values.len(), 240 * 160);
        let mean = found.mean();
        assert!((mean - number(case, "flip_mean")).abs() < 1e-4, "{mean}");

        let found = laplacian::difference(&a, &b).expect("one size");
        assert_eq!(
            found.equal_pixels as f64,
            number(case, "laplacian_equal_pixels")
        );
        assert!((found.mean_abs - number(case, "laplacian_mean_abs")).abs() < 1e-9);
        let histogram: Vec<u64> =
            serde_json::from_value(case["laplacian_histogram"].clone()).expect("a list of counts");
        assert_eq!(found.histogram.to_vec(), histogram);
        let found = differing_pixels(&a, &b).expect("one size");
        assert_eq!(found as f64, number(case, "differing_pixels"));
    }
}

#[test]
fn equal_pictures_are_equal_and_others_are_not() {
    let a = picture("teapot-field.png");
    assert_eq!(psnr(&a, &a), Ok(f64::INFINITY));
    assert!((ssim(&a, &a).expect("one size") - 1.0).abs() < 1e-9);
    let same = flip::flip(&a, &a, flip::PIXELS_PER_DEGREE).expect("one size");
    assert_eq!(same.mean(), 0.0);
    let mut rgb = a.rgb().to_vec();
    let at = 3 * (80 * a.size()[0] as usize + 120);
    rgb[at..at + 3].copy_from_slice(&[255, 0, 255]);
    let b = Rgb8Image::new(a.size(), rgb).expect("a picture");
    assert!(psnr(&a, &b).expect("one size") < 100.0);
    assert!(ssim(&a, &b).expect("one size") < 1.0);
    let other = flip::flip(&a, &b, flip::PIXELS_PER_DEGREE).expect("one size");
    assert!(other.mean() > 1e-5);
    assert_eq!(differing_pixels(&a, &b), Ok(1));
    // A pixel is in the windows of 25.
    let difference = laplacian::difference(&a, &b).expect("one size");
    let differing = 240 * 160 - difference.equal_pixels;
    assert!((5..=25).contains(&differing), "{differing}");
    assert_eq!(difference.histogram.iter().sum::<u64>(), 240 * 160);
    // The greatest difference that there is.
    let plain = |c: [u8; 3]| Rgb8Image::of([40, 30], |_, _| c);
    let most = flip::flip(
        &plain([0, 255, 0]),
        &plain([0, 0, 255]),
        flip::PIXELS_PER_DEGREE,
    );
    let most = most.expect("one size").mean();
    assert!((most - 1.0).abs() < 1e-3, "{most}");
}

#[test]
fn sizes_must_be_one_and_may_be_small() {
    let (a, b) = (
        Rgb8Image::of([4, 3], |_, _| [0; 3]),
        Rgb8Image::of([3, 4], |_, _| [0; 3]),
    );
    assert!(psnr(&a, &b).is_err() && ssim(&a, &b).is_err());
    assert!(flip::flip(&a, &b, 67.0).is_err() && laplacian::difference(&a, &b).is_err());
    assert_eq!(ssim(&a, &a), Ok(1.0));
    let white = Rgb8Image::of([4, 3], |_, _| [255; 3]);
    assert!(ssim(&a, &white).expect("one size") < 0.01);
    let none = Rgb8Image::default();
    assert_eq!(
        flip::flip(&none, &none, 67.0).expect("one size").mean(),
        0.0
    );
    let none = laplacian::difference(&none, &none).expect("one size");
    assert_eq!((none.equal_pixels, none.mean_abs), (0, 0.0));
}
