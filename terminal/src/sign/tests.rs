//! Tests: the signed bytes are those that would be in the flash.

use super::{Arguments, hardware_id, program, run};
use narx_boot::sign::SecretKey;
use narx_boot::{HEADER_LENGTH, Header, Version, hardware};
use std::fs;
use std::path::PathBuf;

/// Builds a 32-bit ELF file for ARM with these segments: address in the flash, and bytes.
fn elf(segments: &[(u32, &[u8])]) -> Vec<u8> {
    let mut file = vec![0x7F, b'E', b'L', b'F', 1, 1, 1];
    file.resize(16, 0);
    let half = |file: &mut Vec<u8>, value: u16| file.extend(value.to_le_bytes());
    let word = |file: &mut Vec<u8>, value: u32| file.extend(value.to_le_bytes());
    // Executable, ARM; version, entry, program headers after this one, no sections, flags.
    half(&mut file, 2);
    half(&mut file, 40);
    [1, 0, 52, 0, 0].into_iter().for_each(|value| word(&mut file, value));
    [52, 32, segments.len() as u16, 40, 0, 0].into_iter().for_each(|value| half(&mut file, value));
    let mut offset = 52 + 32 * segments.len() as u32;
    for (address, bytes) in segments {
        // The virtual address is in RAM: the address from which a segment is loaded counts.
        let length = bytes.len() as u32;
        [1, offset, 0x2000_0000, *address, length, length + 16, 5, 4]
            .into_iter()
            .for_each(|v| word(&mut file, v));
        offset += length;
    }
    segments.iter().for_each(|(_, bytes)| file.extend_from_slice(bytes));
    file
}

#[test]
fn an_elf_file_is_laid_out_as_in_the_flash() {
    let file = elf(&[(0x0800_6210, &[5, 6]), (0x0800_6200, &[1, 2, 3, 4]), (0x0800_6220, &[])]);
    let mut wanted = vec![0xFF; 18];
    wanted[..4].copy_from_slice(&[1, 2, 3, 4]);
    wanted[16..].copy_from_slice(&[5, 6]);
    assert_eq!(program::flat(&file), Ok(wanted));
    assert_eq!(program::flat(b"plain bytes"), Ok(b"plain bytes".to_vec()));
}

#[test]
fn programs_that_no_board_has() {
    let cases: [(Vec<u8>, &str); 5] = [
        (elf(&[]), "nothing to load"),
        (elf(&[(0x0800_6000 + 64, &[1])]), "linked to 08006040h"),
        (elf(&[(0x0800_6000, &[1; 8]), (0x0800_6004, &[1; 8])]), "a segment at 08006004h"),
        (elf(&[(0, &[1; 8]), (0x2000_0000, &[1; 8])]), "a segment at 20000000h"),
        (elf(&[(0, &[1; 8])])[..60].to_vec(), ""),
    ];
    for (file, reason) in cases {
        let error = program::flat(&file).unwrap_err();
        assert!(error.starts_with(reason), "{error}");
    }
}

/// A key is made only once, and the signed image equals the one that the library makes.
#[test]
fn a_key_signs_an_image() {
    let folder = std::env::temp_dir().join(format!("narx-sign-{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    let file = |name: &str| folder.join(name);
    let none =
        || Arguments { image: None, key: None, hardware: None, version: None, out: None, new_key: None };
    let new_key = || Arguments { new_key: Some(file("drive.key")), ..none() };
    run(&new_key()).unwrap();
    let secret = fs::read_to_string(file("drive.key")).unwrap();
    assert!(run(&new_key()).is_err(), "never over a key that exists");
    assert_eq!(fs::read_to_string(file("drive.key")).unwrap(), secret);

    fs::write(file("drive.elf"), elf(&[(0x0800_6200, &[7; 13])])).unwrap();
    let version = Version { major: 1, minor: 2, patch: 3, build: 4 };
    let sign = |key: PathBuf| Arguments {
        image: Some(file("drive.elf")),
        key: Some(key),
        hardware: Some(hardware::QEMU),
        version: Some(version),
        out: Some(file("drive.narximg")),
        ..none()
    };
    run(&sign(file("drive.key"))).unwrap();
    let image = fs::read(file("drive.narximg")).unwrap();
    let header = Header { hardware: hardware::QEMU, version, length: 16 };
    assert_eq!(Header::of(&image), Ok(header));
    let (head, body) = image.split_at(HEADER_LENGTH);
    assert_eq!(body, [[7; 13].as_slice(), &[0xFF; 3]].concat());
    let seed = (0..32).map(|at| u8::from_str_radix(&secret[2 * at..2 * at + 2], 16).unwrap());
    let key = SecretKey(seed.collect::<Vec<u8>>().try_into().unwrap());
    assert_eq!(head, key.sign(header, body));
    // A public key has the form of a secret one and is not recognised; anything else is refused.
    fs::write(file("short.key"), "abcd").unwrap();
    assert!(run(&sign(file("short.key"))).unwrap_err().contains("64 hexadecimal digits"));
    fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn boards_have_names() {
    assert_eq!(hardware_id("qemu"), Ok(hardware::QEMU));
    assert_eq!(hardware_id("4E580002"), Ok(hardware::B_G431B_ESC1));
    assert_eq!(hardware_id("0x4e580002"), Ok(hardware::B_G431B_ESC1));
    assert!(hardware_id("esc1").is_err() && hardware_id("").is_err());
}
