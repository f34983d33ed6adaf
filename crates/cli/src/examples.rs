//! What users type: examples for the help of each command.

/// The command, and its examples, a line each. A test asks clap whether it accepts them.
pub const EXAMPLES: [(&str, &str); 17] = [
    (
        "crowd",
        "\
lemons crowd --number 150 --box 4.56x4.56 --speed 0.5 -o Trial_box
lemons crowd --number 100 --density 5 --fmu crowd.fmu --png crowd.png
lemons crowd --number 80 --box 8x6 --door 8,3,1 --leave -o Trial_room
lemons crowd --geometry walls.xml --region 0,0,8,6 --density 2 -o Trial_part
lemons crowd --number 40 --fixed 49,25,1.75,70 --packing grid -o Trial_rows
lemons crowd --number 10 --pedestrians 0.6 --light-xml mixed.xml",
    ),
    (
        "person",
        "\
lemons person --breadth 49 --depth 25 --stature 1.75 --mass 70
lemons person --breadth 45 --depth 24 --stature 1.63 --mass 67 --sex female \\
    --stl body.stl",
    ),
    (
        "pack",
        "\
lemons pack resources/Trial_push -o push.fmu
lemons pack Trial_a Trial_b --flat-names -o two.fmu",
    ),
    (
        "decide",
        "\
lemons decide resources/Trial_door -o decision.fmu
lemons decide Trial_box --plan plan.toml -o decision.fmu
lemons decide resources/Trial_door --fmi 3 -o decision3.fmu",
    ),
    ("connect", "lemons connect decision.fmu crowd.fmu -o coupled.ssp"),
    (
        "run",
        "\
lemons run resources/Trial_push
lemons run Trial_box --until 2 --accuracy 1e-4
lemons run push.fmu --until 2 --set TimeStepMechanical=1e-5 -o push.csv
lemons run Trial_box --until 600 --format parquet --state box.run
lemons run Trial_box --until 900 -o rest.parquet --resume box.run
lemons run coupled.ssp --until 10 --algorithm gauss-seidel",
    ),
    ("sweep", "lemons sweep sweep.toml -o table.csv"),
    (
        "plot",
        "\
lemons plot resources/Trial_push --at 0.15,0.38,0.54 --fill squeeze
lemons plot trajectories.csv --trial resources/Trial_push --forces -o end.pdf
lemons plot trajectories.csv --series speed,squeeze --agents 0,4 -o speed.svg
lemons plot Trial_box --density -o density.png",
    ),
    (
        "movie",
        "\
lemons movie resources/Trial_push --step 0.005 --speed-up 0.2 -o push.gif
lemons movie trajectories.csv --trial Trial_box --fill speed -o box.mp4",
    ),
    (
        "measure",
        "\
lemons measure resources/Trial_door --until 10 --line door=5,2,5,3
lemons measure walk.csv --trial resources/Trial_door --area front=3,1,5,4
lemons measure box.csv --above 1000,2000 -o measures --plot box.svg",
    ),
    (
        "export",
        "\
lemons export door.csv door.sqlite --to jupedsim --trial crowd.fmu
lemons export trajectories.csv Trial_next --to trial --trial Trial_box",
    ),
    ("info", "lemons info push.fmu --only agent[0]"),
    ("check", "lemons check resources/Trial_push resources/Trial_door"),
    (
        "describe",
        "\
lemons describe resources/Trial_push
lemons describe resources/Trial_door --fmi 3 --plan plan.toml",
    ),
    (
        "lab",
        "\
lemons lab
lemons lab --port 8000 --no-browser",
    ),
    (
        "verify",
        "\
lemons verify
lemons verify --only energy",
    ),
    ("bench", "lemons bench --only dense --runs 3"),
];

/// The help below the options: the examples, then what the command itself says there.
pub fn help_of(command: &str, own: Option<String>) -> String {
    let examples = EXAMPLES.iter().find(|(name, _)| *name == command).map_or("", |(_, examples)| examples);
    let heading = if examples.contains("\nlemons ") { "Examples:" } else { "Example:" };
    let mut help = String::from(heading);
    for line in examples.lines() {
        help += "\n  ";
        help += line;
    }
    if let Some(own) = own {
        help += "\n\n";
        help += &own;
    }
    help
}
