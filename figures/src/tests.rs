//! Figures draw what they are given, and their ticks are numbers that people read.

use super::axis::Axis;
use super::*;

fn labels(axis: &Axis, ends: [f64; 2]) -> Vec<String> {
    axis.ticks(ends, 7)
        .into_iter()
        .filter_map(|t| t.label)
        .collect()
}

#[test]
fn linear_ticks_are_round_numbers() {
    let axis = Axis::linear("x");
    assert_eq!(
        labels(&axis, [-0.02, 1.07]),
        ["0", "0.2", "0.4", "0.6", "0.8", "1.0"]
    );
    assert_eq!(labels(&axis, [-12.0, 31.0]), ["−10", "0", "10", "20", "30"]);
    assert_eq!(
        labels(&axis, [0.0, 4.1e-7]),
        ["0", "1×10⁻⁷", "2×10⁻⁷", "3×10⁻⁷", "4×10⁻⁷"]
    );
    assert_eq!(
        labels(&axis, [0.99, 1.01]),
        ["0.990", "0.995", "1.000", "1.005", "1.010"]
    );
}

/// Panels of a page are narrow: 90 to 200 points beside their bar. Numbers there have about 6 points a digit.
#[test]
fn narrow_axes_have_three_numbers_that_do_not_touch() {
    for (low, high) in [
        (-4400.0, 4400.0),
        (-4000.0, 4000.0),
        (-2200.0, 2200.0),
        (-50.0, 2050.0),
        (-3300.0, 0.0),
        (0.0, 1.05),
        (16_000.0, 24_000.0),
    ] {
        for width in [120.0, 135.0, 170.0, 200.0] {
            let beside = |ticks: &[super::axis::Tick]| {
                let ends = ticks.iter().filter_map(|t| {
                    let half = 0.5 * 6.2 * t.label.as_ref()?.chars().count() as f64;
                    let at = width * (t.at - low) / (high - low);
                    Some([at - half, at + half])
                });
                let ends: Vec<[f64; 2]> = ends.collect();
                ends.windows(2).all(|pair| pair[0][1] + 3.0 < pair[1][0])
            };
            let most = ((width / 60.0) as usize).max(2);
            let ticks = Axis::linear("x").ticks_of_three([low, high], most, beside);
            let labels: Vec<_> = ticks.iter().filter_map(|t| t.label.as_deref()).collect();
            assert!(
                beside(&ticks) && labels.len() >= 3,
                "{low} {high} {width}: {labels:?}"
            );
            if low * high < 0.0 {
                assert!(labels.contains(&"0"), "{labels:?}");
            }
        }
    }
}

#[test]
fn logarithmic_ticks_are_decades_or_plain_numbers() {
    let axis = Axis::log("x");
    assert_eq!(
        labels(&axis, [-3.2, 2.2]),
        ["10⁻³", "10⁻²", "10⁻¹", "1", "10", "10²"]
    );
    assert_eq!(
        labels(&axis, [-14.0, 2.0]),
        ["10⁻¹²", "10⁻⁹", "10⁻⁶", "10⁻³", "1"]
    );
    assert_eq!(labels(&axis, [0.1, 0.9]), ["2", "5"]);
    assert_eq!(labels(&axis, [-0.2, 0.1]), ["0.8", "1.0", "1.2"]);
    let minor = axis
        .ticks([0.0, 2.0], 7)
        .iter()
        .filter(|t| t.label.is_none())
        .count();
    assert_eq!(minor, 16);
}

#[test]
fn a_range_holds_its_data_even_when_all_values_are_equal() {
    for values in [
        vec![3.0],
        vec![0.0],
        vec![1.0, 1.0 + 1e-15],
        vec![-2.0, 5.0],
        vec![1e-320],
    ] {
        let [low, high] = Axis::linear("x").fit(values.iter().copied());
        assert!(
            low < high && values.iter().all(|v| low <= *v && *v <= high),
            "{values:?} in {low}..{high}"
        );
    }
    let [low, high] = Axis::log("x").fit([0.0, 1e-3, 10.0].into_iter());
    assert!(low < -3.0 && high > 1.0);
}

#[test]
fn a_figure_shows_every_point_and_says_what_it_cannot_show() {
    let points = vec![[1.0, 1e-2], [2.0, 1e-4], [4.0, 0.0]];
    let figure = Figure::new("f", "T & t", "", Axis::log("n"), Axis::log("error [m]"))
        .with(Series::new("ours", Mark::LinePoints, points))
        .slope(-2.0, [1.0, 1e-2]);
    let svg = figure.to_svg().unwrap();
    assert!(svg.starts_with("<svg") && svg.contains("width=\"560\""));
    for text in [
        "error [m]",
        "ours (1 of 3 cannot be shown)",
        "slope -2",
        "T &amp; t",
    ] {
        assert!(svg.contains(text), "{text} in {svg}");
    }
    assert_eq!(
        svg.matches("<circle").count(),
        3,
        "two markers and one in the legend"
    );
    let csv = figure.to_csv();
    assert_eq!(csv.lines().nth(3), Some("ours,line+points,4,0"));
}

#[test]
fn a_pdf_shows_what_the_svg_shows_with_its_letters() {
    let points: Vec<[f64; 2]> = (0..9).map(|k| [f64::from(k), f64::from(k * k)]).collect();
    let figure = |points: Vec<[f64; 2]>| {
        Figure::new(
            "f",
            "S_u ≤ 10⁻³",
            "What λ does.",
            Axis::linear("n_it"),
            Axis::linear("λ"),
        )
        .with(Series::new("ours", Mark::Points, points))
        .shade("disc", Region::RealInterval([1.0, 2.0]))
    };
    let pdf = figure(points.clone()).to_pdf().unwrap();
    // the same bytes again; no date, no name of a machine
    assert_eq!(pdf, figure(points.clone()).to_pdf().unwrap());
    assert!(pdf.starts_with(b"%PDF-") && pdf.ends_with(b"%%EOF"));
    let content = super::pdf::drawn(&pdf);
    // nine markers and one in the legend, each a circle of four arcs
    assert_eq!(content.matches(" c\n").count(), 4 * 10, "{content}");
    let few = figure(points[..4].to_vec()).to_pdf().unwrap();
    assert_eq!(super::pdf::drawn(&few).matches(" c\n").count(), 4 * 5);
    // a series of which nothing is shown paints no path
    let none = Figure::new("n", "", "", Axis::linear("x"), Axis::log("y")).with(Series::new(
        "none",
        Mark::LinePoints,
        vec![[1.0, 0.0]],
    ));
    let none = super::pdf::drawn(&none.to_pdf().unwrap());
    let paints = none.lines().filter(|line| ["S", "f"].contains(line));
    assert_eq!(paints.count(), none.matches(" m\n").count(), "{none}");
    // text can be searched: letters and what they mean
    let text = String::from_utf8_lossy(&pdf);
    for letter in "Suniλours≤⁻³".chars() {
        let code = format!("<{:04X}>", u32::from(letter));
        assert!(text.contains(&code), "{letter}");
    }
    assert!(!text.contains("<005F>"), "an index has no underscore");
    assert!(pdf.len() < 60_000, "{} bytes", pdf.len());
}

#[test]
fn the_font_of_a_pdf_has_the_letters_of_figures() {
    let letters = "αβγδΔεηθκλμνρσΣτφχωΩ⁰¹²³⁴⁵⁶⁷⁸⁹⁻₀₁½𝒜≤≥≈≠×·−±∞√∂∫‖∈→←↔°✗✓…–—½§äöüé";
    let missing: Vec<char> = letters.chars().filter(|c| !super::pdf::knows(*c)).collect();
    assert!(missing.is_empty(), "{missing:?}");
}

#[test]
fn the_complex_plane_has_equal_units() {
    let figure = Figure::complex_plane("s", "", "", &[("λ", vec![[0.0, -0.5], [1.0, 0.5]])])
        .shade(
            "disc",
            Region::Disc {
                center: [0.5, 0.0],
                radius: 0.5,
            },
        )
        .shade("real", Region::RealInterval([0.25, 0.75]));
    let svg = figure.to_svg().unwrap();
    let circle = |svg: &str, k: usize| -> (f64, f64) {
        let part = svg.split("<circle").nth(k + 1).unwrap();
        let number = |key: &str| {
            part.split(key)
                .nth(1)
                .unwrap()
                .split('"')
                .next()
                .unwrap()
                .parse()
                .unwrap()
        };
        (number("cx=\""), number("cy=\""))
    };
    let ((x0, y0), (x1, y1)) = (circle(&svg, 0), circle(&svg, 1));
    assert!(
        ((x1 - x0) - (y0 - y1)).abs() <= 2.0,
        "one unit is {} wide and {} high",
        x1 - x0,
        y0 - y1
    );
    assert!(svg.contains("disc") && svg.contains("Im λ"));
}

/// Eigenvalues at half and one, and what stands between them.
fn spectrum(between: [f64; 2], is_partial: bool) -> Spectrum {
    Spectrum {
        augmentation: "local".into(),
        inner: "ssor".into(),
        n_u: 24,
        n_t: 6,
        re: vec![0.02, between[0], between[0], 1.0],
        im: vec![0.0, between[1], -between[1], 0.0],
        real: Some((0.01, 1.0)),
        complex: None,
        circles: Vec::new(),
        is_partial,
        contained: Some(true),
        field: None,
        levels: Vec::new(),
        gmres: None,
    }
}

#[test]
fn a_part_of_a_spectrum_says_so_on_the_page() {
    let seen = |spectrum: &Spectrum| {
        let svg = spectrum.figure("s").to_svg().unwrap();
        svg.split_once("</desc>").unwrap().1.to_owned()
    };
    let says = "every one of the 4 found lies inside";
    for between in [[0.5, 0.0], [0.5, 0.3]] {
        assert!(seen(&spectrum(between, true)).contains(says));
        assert!(!seen(&spectrum(between, false)).contains("found"));
    }
    let unknown = Spectrum {
        contained: None,
        ..spectrum([0.5, 0.0], true)
    };
    let svg = seen(&unknown);
    assert!(svg.contains("4 eigenvalues were found") && !svg.contains("inside"));
    let strips = [("a".to_owned(), &unknown)];
    assert!((Spectrum::strips("t", "", &strips).to_svg().unwrap()).contains("a (4 found)"));
}

#[test]
fn rows_count_what_a_logarithm_cannot_show() {
    let rows = [
        ("local".to_owned(), vec![0.5, 1.0]),
        ("global".to_owned(), vec![0.0, 1e-3, 1.0]),
    ];
    let figure = Figure::rows("r", "", "", Axis::log("λ"), &rows);
    let svg = figure.to_svg().unwrap();
    assert!(svg.contains("global (2 at 0)") && svg.contains(">local") || svg.contains("local\n"));
}

#[test]
fn a_failed_bar_is_a_cross() {
    let names = vec!["A".to_owned(), "B".to_owned()];
    let figure = Figure::new("b", "", "", Axis::categories("", names), Axis::log("cost")).with(
        Series::new("ours", Mark::Bars, vec![[0.0, 100.0], [1.0, f64::NAN]]),
    );
    assert!(figure.to_svg().unwrap().contains('✗'));
}

#[test]
fn cells_are_drawn_with_their_colours_and_a_bar() {
    let mut figure = Figure::new("c", "", "", Axis::linear("x"), Axis::linear("y"));
    let square = |x: f64| [[x, 0.0], [x + 1.0, 0.0], [x + 1.0, 1.0], [x, 1.0]];
    figure.cells = Some(Cells {
        colors: Colors::Diverging,
        label: "t_N [MPa]".into(),
        quads: vec![square(0.0), square(1.0), square(2.0)],
        values: vec![-5.0, 5.0, f64::NAN],
        range: [-5.0, 5.0],
    });
    let svg = figure.to_svg().unwrap();
    // the ends of the palette: one cell each, beside the bar of 64 steps
    let paths = svg.split("<path").skip(1);
    let count = |path: &str| {
        path.split("/>")
            .next()
            .map_or(0, |p| p.matches('M').count())
    };
    let quads: Vec<usize> = paths.map(count).collect();
    assert_eq!((quads.len(), quads.iter().sum::<usize>()), (64, 2 + 64));
    assert_eq!(quads.iter().filter(|n| **n == 2).count(), 2);
    let csv = figure.to_csv();
    assert!(csv.contains("-5,cell,0.5,0.5\n") && csv.contains("5,cell,1.5,0.5\n"));
}

#[test]
fn rectangles_of_one_colour_in_a_row_are_one() {
    let mut figure = Figure::new("r", "", "", Axis::linear("x"), Axis::linear("y"));
    let square = |x: f64| [[x, 0.0], [x + 1.0, 0.0], [x + 1.0, 1.0], [x, 1.0]];
    let names = ["stick", "slip"].map(str::to_owned).to_vec();
    figure.cells = Some(Cells {
        colors: Colors::Classes(names),
        label: "state".into(),
        quads: (0..6).map(|k| square(f64::from(k))).collect(),
        values: vec![0.0, 0.0, 0.0, 1.0, 1.0, 0.0],
        range: [0.0, 1.0],
    });
    let svg = figure.to_svg().unwrap();
    let paths: Vec<&str> = svg.split("<path").skip(1).collect();
    // each with its colour of the bar
    let quads = paths.iter().map(|path| path.matches('M').count());
    assert_eq!(quads.collect::<Vec<_>>(), [2 + 1, 1 + 1]);
    assert!(svg.contains("stick") && svg.contains("slip"));
}

#[test]
fn letters_shrink_until_a_text_fits() {
    use super::canvas::{fitting_size, text_width};
    let text = "proved, complex: Re λ in [0.2333, 1], |Im λ| ≤ 0.5";
    let size = fitting_size(text, 10.0, 200.0);
    assert!(size < 10.0 && (text_width(text, size) - 200.0).abs() < 1e-9);
    assert_eq!(fitting_size("short", 10.0, 200.0), 10.0);
}
