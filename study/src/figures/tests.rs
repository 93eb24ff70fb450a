use std::collections::BTreeSet;

use super::*;

#[test]
fn every_name_stands_once_and_says_what_it_is() {
    let names: Vec<String> = figures().iter().map(|figure| figure.name.to_owned()).collect();
    let of_columns: Vec<String> = columns().iter().map(|column| column.name.clone()).collect();
    for list in [&names, &of_columns] {
        assert_eq!(list.iter().collect::<BTreeSet<_>>().len(), list.len(), "{list:?}");
        assert!(list.iter().all(|name| name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')), "{list:?}");
    }
    assert!(figures().iter().all(|figure| !figure.unit.is_empty() && !figure.description.is_empty()));
    assert!(columns().iter().all(|column| !column.unit.is_empty() && !column.description.is_empty()));
}

#[test]
fn every_value_is_a_column_and_every_cost_one_of_each_part() {
    let values = figures().iter().filter(|figure| figure.form == Form::Value);
    values.for_each(|figure| assert!(column(figure.name).is_some_and(|c| c.is_figure), "{}", figure.name));
    for cost in RunCost::figures() {
        assert!(cost.of_part.is_some(), "{} has no text for a part of the machine", cost.name);
        for part in ["ti_with_memory", "gpu"] {
            let scoped = column(&format!("{part}_{}", cost.name)).unwrap();
            assert_eq!((scoped.unit, scoped.better), (cost.unit, cost.better));
        }
    }
    assert_eq!(column("gpu_power_w").unwrap().description, "whole GPU: mean power");
    assert_eq!(
        column("ti_with_memory_energy_mj").unwrap().description,
        "T&I units with their L2 and DRAM energy: energy"
    );
    assert_eq!(column("power_w").unwrap().description, "mean power of the T&I units alone, the group ti of energy");
    for group in ["gpu", "counters", "units", "energy", "machine_config", "rays_by_kind"] {
        assert!(is_key(group) && column(group).is_none(), "{group}");
    }
}

#[test]
fn rays_by_kind_have_a_column_for_each_part() {
    let counts = ByKind { full: Default::default(), traced: Default::default(), apron: Default::default() };
    let json = serde_json::json!({ "rays_by_kind": counts });
    let leaves: usize =
        json["rays_by_kind"].as_object().unwrap().values().map(|part| part.as_object().unwrap().len()).sum();
    let by_kind: Vec<&FixedColumn> = columns().iter().filter(|column| !column.is_figure).collect();
    assert_eq!(by_kind.len(), leaves);
    by_kind.iter().for_each(|column| assert!(column.value(&json).is_u64(), "{}", column.name));
}
