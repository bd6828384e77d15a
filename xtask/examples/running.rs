fn main() {
    let r = xtask::running::Running::record(std::path::Path::new("target/running")).unwrap();
    println!("{:?}", r.labels);
    if std::env::args().nth(1).is_some() {
        println!("vectors");
    }
}
