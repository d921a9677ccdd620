//! Measures of pictures against SciPy, scikit-image and the authors' FLIP (`data/reference.py`), on pictures that Argil drew.

use argil_metrics::{differing_pixels, flip, laplacian, psnr, ssim};
use image::RgbImage;
use serde_json::Value;
use std::path::PathBuf;

fn data(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("tests/data")
        .join(name)
}

fn picture(name: &str) -> RgbImage {
    image::open(data(name)).expect("a picture").to_rgb8()
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
        let found = flip::flip(&a, &b, flip::PIXELS_A_DEGREE).expect("one size");
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
    let same = flip::flip(&a, &a, flip::PIXELS_A_DEGREE).expect("one size");
    assert_eq!(same.mean(), 0.0);
    let mut b = a.clone();
    b.get_pixel_mut(120, 80).0 = [255, 0, 255];
    assert!(psnr(&a, &b).expect("one size") < 100.0);
    assert!(ssim(&a, &b).expect("one size") < 1.0);
    let other = flip::flip(&a, &b, flip::PIXELS_A_DEGREE).expect("one size");
    assert!(other.mean() > 1e-5);
    assert_eq!(differing_pixels(&a, &b), Ok(1));
    // A pixel is in the windows of 25.
    let difference = laplacian::difference(&a, &b).expect("one size");
    let differing = 240 * 160 - difference.equal_pixels;
    assert!((5..=25).contains(&differing), "{differing}");
    assert_eq!(difference.histogram.iter().sum::<u64>(), 240 * 160);
    // The greatest difference that there is.
    let plain = |c: [u8; 3]| RgbImage::from_pixel(40, 30, image::Rgb(c));
    let most = flip::flip(
        &plain([0, 255, 0]),
        &plain([0, 0, 255]),
        flip::PIXELS_A_DEGREE,
    );
    let most = most.expect("one size").mean();
    assert!((most - 1.0).abs() < 1e-3, "{most}");
}

#[test]
fn sizes_must_be_one_and_may_be_small() {
    let (a, b) = (RgbImage::new(4, 3), RgbImage::new(3, 4));
    assert!(psnr(&a, &b).is_err() && ssim(&a, &b).is_err());
    assert!(flip::flip(&a, &b, 67.0).is_err() && laplacian::difference(&a, &b).is_err());
    assert_eq!(ssim(&a, &a), Ok(1.0));
    let white = RgbImage::from_pixel(4, 3, image::Rgb([255; 3]));
    assert!(ssim(&a, &white).expect("one size") < 0.01);
    let none = RgbImage::new(0, 0);
    assert_eq!(
        flip::flip(&none, &none, 67.0).expect("one size").mean(),
        0.0
    );
    let none = laplacian::difference(&none, &none).expect("one size");
    assert_eq!((none.equal_pixels, none.mean_abs), (0, 0.0));
}
