//! Claim: what a field of pressures cannot say is refused with file, cell or row.

use crate::pore_fields::{scene, vtu};
use crate::pore_pressure::Folder;

#[test]
fn fields_are_refused_with_their_cell_or_row() {
    let folder = Folder::empty("bad-fields");
    let head = "x [m],y [m],z [m],0 day [bar],5 day [bar]\n";
    let said = |form: &str| match folder.read(&scene(form, "")).map(|scene| scene.build()) {
        Ok(Ok(_)) => panic!("accepted {form}"),
        Ok(Err(error)) => error.to_string(),
        Err(text) => text,
    };
    for (text, expected) in [
        (
            format!("{head}1,3,-1,2,1\n1,3,-1,2,2\n"),
            "p.csv: row 2 and row 3 both lie at (1.000000, 3.000000, -1.000000) m and differ in pressure",
        ),
        (
            format!("{head}1,3,-1,2,1\n\n1,3,-2,2,\n"),
            "p.csv, row 4: column `5 day` is ``, which is no number",
        ),
        (
            format!("{head}1,3,-1,2,nan\n"),
            "row 2: column `5 day` is `nan`",
        ),
        (format!("{head}1,3,inf,2,1\n"), "row 2: column `z` is `inf`"),
        (
            format!("{head}1,3,-1,2,-1\n"),
            "p.csv, row 2, column `5 day`: a pore pressure is \"-1 bar\", but it must be zero or positive",
        ),
        (
            format!("{head}1,3,-1,2,1,7\n"),
            "p.csv, row 2 has 6 cells and the heading 5",
        ),
        (head.to_string(), "p.csv has no row"),
        (String::new(), "p.csv has no row"),
        (
            "x [m],y [m],z [m],5 day [bar],0 day [bar]\n1,3,-1,2,1\n".into(),
            "p.csv, row 1, column 5: time 0 s does not come after 432000 s",
        ),
        (
            "x [m],y [m],z [m]\n1,3,-1\n".into(),
            "p.csv, row 1: the heading must be `x [m],y [m],z [m],0 year [bar],…`",
        ),
        (
            "x [m],y [m],z [m],0 day [kg]\n1,3,-1,1\n".into(),
            "column 4 is `0 day [kg]`",
        ),
        (
            "x [m],y [m],z [m],0 day\n1,3,-1,1\n".into(),
            "column 4 is `0 day`",
        ),
        ("x,y,z,0 day [bar]\n1,3,-1,1\n".into(), "column 1 is `x`"),
        (
            "x [m],z [m],y [m],0 day [bar]\n1,3,-1,1\n".into(),
            "column 2 is `z [m]`",
        ),
        (
            format!("{head}1.5,3,-1,2,1\n1.5,3,-1.1,2,1\n"),
            "element 0 of material \"rock\" around (1.125000, 2.333333, -2.700000) m is",
        ),
        (
            "x [m],y [m],z [m],10 day [bar],20 day [bar]\n1.5,3,-1,2,1\n1.5,3,-2,2,1\n".into(),
            "",
        ),
    ] {
        folder.write("p.csv", &text);
        let found = match expected {
            "" => {
                let found = said("{ grid = 'p.csv', within = '9 m' }");
                assert!(
                    found.contains("begins at 10 day, and the run ends at 10 day"),
                    "{found}"
                );
                continue;
            }
            _ => said("{ grid = 'p.csv' }"),
        };
        assert!(
            found.contains(expected) && found.contains("scene.toml:"),
            "{text}: {found}"
        );
    }
    let points = [[1.5, 3.0, -2.0], [1.5, 3.0, -1.0], [1.5, 3.0, -2.0]];
    folder.write("good.vtu", vtu(&points, &[3.0, 2.0, 3.0]));
    folder.write("none.vtu", vtu(&[], &[]));
    folder.write("nan.vtu", vtu(&points, &[3.0, f64::NAN, 3.0]));
    folder.write("low.vtu", vtu(&points, &[3.0, -2.0, 3.0]));
    folder.write("two.vtu", vtu(&points, &[3.0, 2.0, 4.0]));
    folder.write("place.vtu", vtu(&[[1.0, f64::INFINITY, 0.0]], &[3.0]));
    folder.write("text.vtu", "pressure");
    for (files, more, expected) in [
        ("['0 day', 'good.vtu']", "", "needs `unit`"),
        (
            "['0 day', 'good.vtu']",
            "unit = 'm'",
            "`unit` of the array: ",
        ),
        (
            "['0 day', 'good.vtu']",
            "unit = 'bar', array = 'p'",
            "good.vtu has no array `p` of cells or points; it has: pressure",
        ),
        (
            "['0 day', 'good.vtu'], ['0 day', 'good.vtu']",
            "unit = 'bar'",
            "`fields` of material \"rock\", row 2: time 0 s does not come after 0 s",
        ),
        (
            "",
            "unit = 'bar'",
            "`fields` of material \"rock\" has no row",
        ),
        (
            "['0 day', 'gone.vtu']",
            "unit = 'bar'",
            "cannot read gone.vtu",
        ),
        (
            "['0 day', 'none.vtu']",
            "unit = 'bar'",
            "none.vtu has no point",
        ),
        (
            "['0 day', 'nan.vtu']",
            "unit = 'bar'",
            "nan.vtu, point 1: `pressure` is NaN; give it a pressure",
        ),
        (
            "['0 day', 'low.vtu']",
            "unit = 'bar'",
            "low.vtu, point 1: `pressure` is -2; a pore pressure is zero or positive",
        ),
        (
            "['0 day', 'two.vtu']",
            "unit = 'bar'",
            "two.vtu: point 0 and point 2 both lie at (1.500000, 3.000000, -2.000000) m",
        ),
        (
            "['0 day', 'place.vtu']",
            "unit = 'bar'",
            "place.vtu, point 0: a coordinate is inf",
        ),
        (
            "['0 day', 'text.vtu']",
            "unit = 'bar'",
            "text.vtu is no unstructured grid of VTK that can be read: it has no <VTKFile>",
        ),
        (
            "['0 day', 'good.vtu']",
            "unit = 'bar', within = '0.1 m'",
            "beyond 0.100000 m; give points that reach it, or a larger `within`",
        ),
        (
            "['0 day', 'good.vtu']",
            "unit = 'bar', column = 'rock'",
            "`column` of `pore_pressure` of material \"rock\" has no effect without `file`",
        ),
        (
            "['0 day', 'good.vtu']",
            "unit = 'bar', digest = '12'",
            "are not those that `digest` was taken of (12, now ",
        ),
        (
            "['0 day', 'good.vtu']",
            "unit = 'bar', points = [['0 day', '1 bar']]",
            "needs exactly one of `points`, `file`, `fields`, `grid`, `drawdown`; it has 2",
        ),
    ] {
        let found = said(&format!("{{ fields = [{files}], {more} }}").replace(", }", " }"));
        assert!(
            found.contains(expected) && found.contains("scene.toml:"),
            "{files} {more}: {found}"
        );
    }
    for (more, expected) in [
        (
            "array = 'p'",
            "`array` of `pore_pressure` of material \"rock\" has no effect without `fields`",
        ),
        ("unit = 'bar'", "`unit` of `pore_pressure`"),
        ("within = '1 m'", "has no effect without `fields` or `grid`"),
        ("digest = '1'", "has no effect without `fields` or `grid`"),
    ] {
        let found = said(&format!("{{ points = [['0 day', '1 bar']], {more} }}"));
        assert!(found.contains(expected), "{more}: {found}");
    }
}
