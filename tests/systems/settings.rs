//! Claim: settings of a solve are plain data, and refused where they are out of range.

use fracas::solve::{InnerRule, Problem, RightHandSide, Solve};

#[test]
fn settings_are_plain_data_that_reads_back() {
    let text = "method = 'racp:0'\ninner = 'auto'\nkrylov = 'sqmr'\nmeasure = 'residual'\nrhs = 'sin(i)'\n";
    let settings: Solve = toml::from_str(text).unwrap();
    assert_eq!(settings.inner, InnerRule::Auto);
    assert_eq!(settings.rhs, Some(RightHandSide::Sin));
    assert_eq!(settings.tolerance, Solve::default().tolerance);
    let again = serde_json::to_string(&settings).unwrap();
    assert_eq!(serde_json::from_str::<Solve>(&again).unwrap(), settings);
    assert!(toml::from_str::<Solve>("methd = 'racp'").is_err());
}

#[test]
fn settings_out_of_range_are_refused_before_anything_is_read() {
    let nowhere = Problem::Folder("nowhere".into());
    let said = |settings: Solve| settings.route(&nowhere).unwrap_err().to_string();
    let tolerance = |tolerance| Solve {
        tolerance,
        ..Solve::default()
    };
    for wrong in [0.0, -1.0, 1.0, f64::NAN] {
        assert!(said(tolerance(wrong)).contains("tolerance"));
    }
    let unit = Solve {
        traction_unit: Some(f64::INFINITY),
        ..Solve::default()
    };
    assert!(said(unit).contains("unit of tractions"));
    assert!(tolerance(0.5).route(&nowhere).is_ok());
}
