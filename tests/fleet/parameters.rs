//! The columns of a fleet from files and tables, and every fault in them at once.

use std::path::{Path, PathBuf};

use column_twin::parameters::{
    FleetColumn, FleetColumns, FleetSources, MAX_COLUMNS, NodeName, Source, Value, parse_override,
};
use tempfile::TempDir;

/// A folder with a parameter file and a table.
struct Files {
    folder: TempDir,
}

impl Files {
    fn new(yaml: &str, table: &str) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("fleet.yaml"), yaml).expect("written");
        std::fs::write(folder.path().join("columns.csv"), table).expect("written");
        Self { folder }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn load(&self, arguments: &[&str]) -> Result<FleetColumns, String> {
        let table = self.path("columns.csv");
        let has_table = std::fs::metadata(&table).is_ok_and(|it| it.len() > 0);
        let sources = FleetSources {
            files: vec![self.path("fleet.yaml")],
            table: has_table.then_some(table),
            arguments: arguments
                .iter()
                .map(|it| Source::Override(parse_override(it)))
                .collect(),
        };
        FleetColumns::load(&NodeName::default(), &sources).map_err(|faults| {
            let folder = format!("{}/", self.folder.path().display());
            faults.to_string().replace(&folder, "")
        })
    }
}

fn of_yaml(yaml: &str) -> Result<FleetColumns, String> {
    Files::new(yaml, "").load(&[])
}

fn get(columns: &[FleetColumn], name: &str, parameter: &str) -> Option<Value> {
    let column = columns.iter().find(|it| it.name == name)?;
    column.parameters.get(parameter)
}

const GARAGE: &str = "\
/**:
  ros__parameters: {top.load: 1.0e5, solver.dt: 1.0e-4, state.directory: /var/states}
/garage/*:
  ros__parameters: {top: {load: 2.0e5}}
/garage/a3:
  ros__parameters: {geometry.length_below: 1.3}
/garage/a4:
  ros__parameters:
/hall/b1/column_twin:
  ros__parameters: {column_id: B-1}
/garage/**:
  ros__parameters: {response.duration: 0.5}
";

#[test]
fn sections_are_columns_or_for_columns_and_later_ones_win() {
    let fleet = of_yaml(GARAGE).expect("right");
    let names: Vec<_> = fleet.columns.iter().map(|it| &*it.name).collect();
    assert_eq!(names, ["/garage/a3", "/garage/a4", "/hall/b1"]);
    for (name, parameter, value) in [
        ("/garage/a3", "column_id", Value::from("a3")),
        ("/garage/a4", "column_id", Value::from("a4")),
        ("/hall/b1", "column_id", Value::from("B-1")),
        ("/garage/a3", "geometry.length_below", Value::Double(1.3)),
        ("/garage/a3", "top.load", Value::Double(2e5)),
        ("/garage/a4", "top.load", Value::Double(2e5)),
        ("/hall/b1", "top.load", Value::Double(1e5)),
        ("/garage/a4", "response.duration", Value::Double(0.5)),
        ("/hall/b1", "solver.dt", Value::Double(1e-4)),
    ] {
        assert_eq!(
            get(&fleet.columns, name, parameter),
            Some(value),
            "{name} {parameter}"
        );
    }
    let default = column_twin::parameters::Parameters::default();
    assert_eq!(
        get(&fleet.columns, "/hall/b1", "response.duration"),
        default.get("response.duration")
    );
    assert_eq!(fleet.node.settings().state.directory, "/var/states");
}

#[test]
fn a_table_wins_over_files_and_arguments_over_both() {
    let table = "namespace,column_id,top.load,section.name\r\n\
                 /garage/a3,a3,3e5,HEB 240\r\n\
                 \"/garage/c1\",12,,\"HEB 300\"\r\n";
    let files = Files::new(GARAGE, table);
    let fleet = files.load(&["response.duration:=0.4"]).expect("right");
    assert_eq!(fleet.columns.len(), 4);
    for (name, parameter, value) in [
        ("/garage/a3", "top.load", Value::Double(3e5)),
        ("/garage/a3", "geometry.length_below", Value::Double(1.3)),
        ("/garage/c1", "top.load", Value::Double(2e5)),
        ("/garage/c1", "column_id", Value::from("12")),
        ("/garage/c1", "section.name", Value::from("HEB300")),
        ("/garage/c1", "response.duration", Value::Double(0.4)),
    ] {
        assert_eq!(
            get(&fleet.columns, name, parameter),
            Some(value),
            "{name} {parameter}"
        );
    }
}

#[test]
fn the_shipped_files_are_a_fleet() {
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("config");
    let sources = FleetSources {
        files: vec![shipped.join("fleet.yaml")],
        table: Some(shipped.join("fleet.csv")),
        arguments: Vec::new(),
    };
    let fleet = FleetColumns::load(&NodeName::default(), &sources).expect("right");
    assert_eq!(fleet.columns.len(), 5);
    assert!(fleet.warnings.is_empty(), "{:?}", fleet.warnings);
}

#[test]
fn all_faults_are_told_at_once_with_row_and_column() {
    let yaml = "\
/**:
  ros__parameters: {top.load: -1.0, lidar.port: 3}
/garage/a3:
  ros__parameters: {geometry.lenght_below: 1.3, record.mode: always}
/garage/a4:
  ros__parameters: {column_id: a3}
";
    let table = "namespace,column_id,top.load,steel.grade\n\
                 /garage/b1,b1,heavy,S355\n\
                 /garage/b1,b2,,\n\
                 ,b3,,\n\
                 /garage/b4,b4,1e5\n\
                 /garage/b5,b5,2e5,S999\n";
    let faults = Files::new(yaml, table).load(&[]).expect_err("faults");
    for expected in [
        "fleet.yaml:2:31: top.load: `-1.0` is out of range",
        "fleet.yaml:4:21: geometry.lenght_below is not a parameter (did you mean geometry.length_below?)",
        "fleet.yaml:4:49: record.mode belongs to the node, which all columns share; give it in the section `/**:`",
        "columns.csv:2:15: top.load: `heavy` is",
        "columns.csv:3:1: there are two rows of the column /garage/b1; remove one of them",
        "columns.csv:4:1: namespace is not the name of one column; write it as /garage/a3",
        "columns.csv:5:1: the row has 3 fields, but the first row has 4; add or remove commas",
        "columns.csv:6:19: steel.grade: `S999` is not known",
    ] {
        assert!(faults.contains(expected), "{expected} is not in\n{faults}");
    }
    assert_eq!(
        faults.matches("top.load: `-1.0`").count(),
        1,
        "shared by all columns: {faults}"
    );
}

#[test]
fn two_columns_of_one_name_are_a_fault() {
    let faults =
        of_yaml("/a/x:\n  ros__parameters: {}\n/b/x:\n  ros__parameters: {top.load: 1.0e5}\n");
    let expected = "fleet.yaml:4:3: /b/x has the column_id \"x\", which /a/x has too; give each column its own";
    let faults = faults.expect_err("one name");
    assert!(faults.contains(expected), "{faults}");
}

#[test]
fn more_columns_than_a_fleet_has_are_a_fault() {
    let rows = |count: usize| -> String {
        let rows = (0..count).map(|number| format!("/hall/c{number},c{number}\n"));
        "namespace,column_id\n"
            .chars()
            .chain(rows.collect::<String>().chars())
            .collect()
    };
    let yaml = "/**:\n  ros__parameters: {solver.dt: 1.0e-4}\n";
    let most = Files::new(yaml, &rows(MAX_COLUMNS))
        .load(&[])
        .expect("as many as possible");
    assert_eq!(most.columns.len(), MAX_COLUMNS);
    let faults = Files::new(yaml, &rows(MAX_COLUMNS + 1))
        .load(&[])
        .expect_err("one more");
    let expected = format!(
        "columns.csv:{}:1: /hall/c{MAX_COLUMNS} is column {}, but a fleet has at most {MAX_COLUMNS}",
        MAX_COLUMNS + 2,
        MAX_COLUMNS + 1
    );
    assert!(faults.contains(&expected), "{faults}");
    assert_eq!(faults.lines().count(), 2, "{faults}");
}

#[test]
fn wrong_tables_and_empty_fleets_are_faults_and_never_panic() {
    let yaml = "/**:\n  ros__parameters: {top.load: 1.0e5}\n";
    let none = Files::new(yaml, "").load(&[]).expect_err("no column");
    assert!(
        none.contains("the fleet has no column; name each in a parameter file"),
        "{none}"
    );
    for (table, expected) in [
        (
            "namespace,top.load\n/a,1e5\n",
            "the first row does not name column_id",
        ),
        ("column_id\nx\n", "the first row does not name namespace"),
        (
            "namespace,column_id,top.load,top.load\n/a,a,1,2\n",
            "columns.csv:1:30: \"top.load\" is given a second time",
        ),
        // `column-twin run` rejects them, too.
        (
            "namespace,column_id\n/garage/b-1,a\n",
            "columns.csv:2:1: \"/garage/b-1\" is not a namespace of ROS: only letters, digits and underscores",
        ),
        (
            "namespace,column_id\n/a b<x>/..//=1,a\n",
            "columns.csv:2:1: \"/a b<x>/../=1\" is not a namespace of ROS",
        ),
        (
            "namespace,column_id\n/3a,a\n",
            "no part may begin with a digit",
        ),
        (
            "namespace,column_id\n/a/*,a\n",
            "namespace is not the name of one column",
        ),
        (
            "namespace,column_id,top.laod\n/a,a,1\n",
            "top.laod is not a parameter (did you mean top.load?)",
        ),
        (
            "namespace,column_id,top.load\n/a,a,[1\n",
            "columns.csv:2:6: top.load: `[1` has a value that is not valid YAML",
        ),
        (
            "namespace,column_id,top.load\n/a,a,\"1,\n",
            "columns.csv:2:",
        ),
        ("\n\n", "the table is empty"),
    ] {
        let faults = Files::new(yaml, table).load(&[]).expect_err(table);
        assert!(faults.contains(expected), "{table}\n{faults}");
    }
    let named = of_yaml("/garage/b-1:\n  ros__parameters: {}\n").expect_err("no namespace");
    assert!(
        named.contains("fleet.yaml:2:3: \"/garage/b-1\" is not a namespace of ROS"),
        "{named}"
    );
    assert!(!named.contains("has no column"), "{named}");
    let broken = Files::new("/**: [", "namespace,column_id\n/a,a\n").load(&[]);
    let broken = broken.expect_err("no YAML");
    assert!(
        broken.contains("fleet.yaml:") && broken.contains("not valid YAML"),
        "{broken}"
    );
    // Any cut of a table is a table or a fault.
    let table = "namespace,column_id,top.load\r\n\"/a\",\"a \"\"1\"\"\",1e5\r\n/ä,ö,2e5\n";
    for end in (0..table.len()).filter(|it| table.is_char_boundary(*it)) {
        let _ = Files::new(yaml, &table[..end]).load(&[]);
    }
}

/// `column-twin run` with several columns in its files is a fleet; with its own section, or with sections of other nodes, it is not.
#[test]
fn several_columns_in_the_files_of_run_are_a_fleet() {
    let are_several = |yaml: &str, namespace: &str| {
        let files = Files::new(yaml, "");
        let node = NodeName::new(namespace, "column_twin");
        FleetColumns::are_named_in(&node, [files.path("fleet.yaml").as_path()])
    };
    let one = "/garage/a3:\n  ros__parameters: {top.load: 1.0e5}\n";
    assert!(!are_several(one, "/"), "it has one column");
    assert!(are_several(GARAGE, "/"));
    let as_nodes = "\
/garage/a3/column_twin:
  ros__parameters: {top.load: 1.0e5}
/garage/a4/column_twin:
  ros__parameters: {top.load: 2.0e5}
";
    assert!(are_several(as_nodes, "/"));
    assert!(!are_several(as_nodes, "/garage/a3"), "it names this node");
    let of_others =
        format!("{GARAGE}/camera:\n  ros__parameters: {{use_sim_time: true, exposure: 3}}\n");
    assert!(!are_several(&of_others, "/"), "a camera is no column");
    let own = format!("{GARAGE}column_twin:\n  ros__parameters: {{top.load: 3.0e5}}\n");
    assert!(!are_several(&own, "/"), "it names this node");
}
