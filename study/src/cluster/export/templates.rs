//! The templates by engine.

/// An engine with its files.
#[derive(Clone, Copy, Debug)]
pub struct Engine {
    /// What `--engine` calls it.
    pub name: &'static str,
    /// What people call it.
    pub title: &'static str,
    /// File names and templates.
    pub(super) files: &'static [(&'static str, &'static str)],
    /// How it is begun, from the folder of the files.
    pub begin: &'static str,
}

macro_rules! files {
    ($($name:literal: $path:literal),* $(,)?) => { &[$(($name, include_str!(concat!("templates/", $path)))),*] };
}

/// All engines.
pub const ENGINES: &[Engine] = &[
    Engine {
        name: "htcondor",
        title: "HTCondor",
        files: files! {
            "sweep.dag": "htcondor.dag",
            "shards.sub": "htcondor-shards.sub",
            "merge.sub": "htcondor-merge.sub",
            "shard.sh": "htcondor-shard.sh",
            "merge.sh": "merge.sh",
        },
        begin: "condor_submit_dag sweep.dag",
    },
    Engine {
        name: "lsf",
        title: "IBM LSF",
        files: files! { "submit.sh": "lsf-submit.sh", "shard.sh": "lsf-shard.sh", "merge.sh": "merge.sh" },
        begin: "./submit.sh",
    },
    Engine {
        name: "k8s",
        title: "Kubernetes",
        files: files! { "shards.yaml": "k8s-shards.yaml", "merge.yaml": "k8s-merge.yaml" },
        begin: "kubectl apply -f shards.yaml",
    },
    Engine {
        name: "aws-batch",
        title: "AWS Batch",
        files: files! { "definition.json": "aws-definition.json", "submit.sh": "aws-submit.sh" },
        begin: "./submit.sh QUEUE",
    },
    Engine { name: "hq", title: "HyperQueue", files: files! { "submit.sh": "hq-submit.sh" }, begin: "./submit.sh" },
    Engine {
        name: "parallel",
        title: "GNU parallel",
        files: files! { "run.sh": "parallel-run.sh" },
        begin: "./run.sh",
    },
];
