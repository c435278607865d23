//! Claim: inner solvers are read and written by their names.

use fracas_solvers::saddle::InnerChoice;

/// Names of the house's inner solvers.
const NAMES: [&str; 13] = [
    "exact",
    "amg",
    "amg:gauss_seidel",
    "amg:fsai",
    "amg:chebyshev",
    "fsai",
    "fsai:static",
    "jacobi",
    "ssor",
    "geometric",
    "gamg",
    "boomeramg",
    "mumps",
];

#[test]
fn tables_are_read_and_an_unknown_key_is_answered_with_those_that_there_are() {
    let read = |text: &str| serde_json::from_str::<InnerChoice>(text);
    for two in [r#"{"amg": {}, "ssor": {}}"#, r#"{"geometric": {}, "x": 1}"#] {
        let said = read(two).unwrap_err().to_string();
        assert!(said.contains("stands beside another name"), "{said}");
    }
    for choice in [
        InnerChoice::default(),
        "amg".parse().unwrap(),
        "geometric:k".parse().unwrap(),
    ] {
        let written = serde_json::to_string(&choice).unwrap();
        assert_eq!(read(&written).unwrap(), choice);
    }
    for (text, said) in [
        (
            r#"{"geometric":{"degre":2}}"#,
            "unknown field `degre`, expected one of `degree`, ",
        ),
        (
            r#"{"geometrc":{"degree":2}}"#,
            "unknown variant `geometrc`, expected one of `exact`, ",
        ),
        (
            r#"{"ssor":{"omega":3}}"#,
            "relaxation omega = 3: expected a number between 0 and 2",
        ),
        (
            r#"{"boomeramg":{"strong_threshold":2}}"#,
            "strong_threshold = 2: expected a number from 0 to 1",
        ),
        (
            r#"{"gamg":{"options":"pc_gamg_threshold 0"}}"#,
            "\"pc_gamg_threshold\" is no option of PETSc",
        ),
        ("7", "expected an inner solver such as \"ssor\""),
    ] {
        let error = read(text).unwrap_err().to_string();
        assert!(error.contains(said), "{error}");
    }
}

#[test]
fn every_name_gives_itself_back_and_a_wrong_one_hears_of_all() {
    for name in NAMES {
        assert_eq!(name.parse::<InnerChoice>().unwrap().to_string(), name);
    }
    for name in ["amg:f64", "amg:gauss_seidel:f64", "amg:chebyshev:f64"] {
        let double = name.parse::<InnerChoice>().unwrap();
        assert_eq!(
            (double.to_string(), double.in_double()),
            (name.to_owned(), None)
        );
    }
    for wrong in [
        "amg:",
        "amg:sor",
        "AMG",
        "",
        "amg:f32",
        "amg:f64:f64",
        ":f64",
    ] {
        let message = wrong.parse::<InnerChoice>().unwrap_err().to_string();
        assert!(NAMES.iter().all(|name| message.contains(name)), "{message}");
    }
}
