//! Claim: iterations are read and written by their names.

use fracas_solvers::krylov::{Gmres, KrylovChoice};

#[test]
fn what_is_written_reads_back() {
    for choice in KrylovChoice::all() {
        assert_eq!(choice.to_string().parse(), Ok(choice));
        let json = serde_json::to_string(&choice).unwrap();
        assert_eq!(serde_json::from_str::<KrylovChoice>(&json).unwrap(), choice);
    }
}

#[test]
fn names_and_tables_are_read() {
    let fifty = KrylovChoice::Gmres(Gmres::restarted(50));
    assert_eq!("gmres:50".parse(), Ok(fifty));
    let read = |text: &str| serde_json::from_str::<KrylovChoice>(text);
    assert_eq!(read(r#"{"gmres":{"restart":50}}"#).unwrap(), fifty);
    assert_eq!(read(r#"{"gmres":{}}"#).unwrap(), KrylovChoice::default());
    assert_eq!(read(r#""sqmr""#).unwrap().name(), "sqmr");
    for wrong in [
        r#""gmers""#,
        r#""gmres:0""#,
        r#""cg:5""#,
        r#"{"gmres":{"restart":0}}"#,
        r#"{"gmres":{"restarts":5}}"#,
        "7",
    ] {
        assert!(read(wrong).is_err(), "{wrong}");
    }
    assert!(
        "gmers"
            .parse::<KrylovChoice>()
            .unwrap_err()
            .to_string()
            .contains("`gmers`")
    );
}

#[test]
fn the_schema_knows_every_method() {
    let schema = serde_json::to_string(&schemars::schema_for!(KrylovChoice)).unwrap();
    for choice in KrylovChoice::all() {
        assert!(schema.contains(choice.name()));
    }
}
