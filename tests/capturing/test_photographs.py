"""Photographs of poses: order in folders, EXIF, what is refused early and why."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from PIL import ExifTags, Image, ImageOps, TiffImagePlugin
from scipy.ndimage import gaussian_filter

from elastomorph.capturing.photographs import (
    Exif,
    compared,
    examine,
    find_masks,
    find_poses,
    read_exif,
    read_mask,
    read_upright,
    sharpness,
)
from elastomorph.errors import CaptureError, FileError, FormatError

RANDOM = np.random.default_rng(5)
BASE = ExifTags.Base


def skin(number: int = 0, size: tuple[int, int] = (160, 120)) -> np.ndarray:
    """Noise of all scales, (H, W, 3), another for each number."""
    random = np.random.default_rng(number)
    noise = sum(
        width * gaussian_filter(random.normal(size=size[::-1]), width) for width in (0.7, 2, 5, 12)
    )
    noise = 128 + 40 * noise / noise.std()
    return np.repeat(np.clip(noise, 0, 255).astype(np.uint8)[..., None], 3, axis=2)


def exif(**values: object) -> Image.Exif:
    """EXIF with these values, by their names."""
    found = Image.Exif()
    inner = found.get_ifd(ExifTags.IFD.Exif)
    for name, value in values.items():
        key = BASE[name]
        (found if key in (BASE.Make, BASE.Model, BASE.Orientation) else inner)[key] = value
    return found


def write(path: Path, pixels: np.ndarray, **values: object) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(pixels).save(path, quality=95, exif=exif(**values))
    return path


@pytest.fixture
def twelve(tmp_path: Path) -> list[Path]:
    """A pose of twelve photographs of one camera."""
    return [
        write(tmp_path / "smile" / f"IMG_{k}.jpg", skin(k), Model="X1", FocalLengthIn35mmFilm=50)
        for k in range(12)
    ]


def test_one_folder_a_pose_in_natural_order(tmp_path):
    for pose in ("smile", "neutral"):
        for number in (10, 2, 1):
            write(tmp_path / pose / f"IMG_{number}.JPG", skin())
    (tmp_path / "neutral" / "notes.txt").write_text("x")
    (tmp_path / "masks").mkdir()
    write(tmp_path / "masks" / "IMG_1.png", skin())
    found = find_poses(tmp_path)
    assert list(found) == ["neutral", "smile"]
    assert [path.name for path in found["smile"]] == ["IMG_1.JPG", "IMG_2.JPG", "IMG_10.JPG"]


def test_poses_named_in_one_folder(tmp_path):
    for name in ("jaw_open_01", "jaw_open_02", "neutral-1", "neutral-2", "t05 (1)"):
        write(tmp_path / f"{name}.jpg", skin())
    found = {pose: len(paths) for pose, paths in find_poses(tmp_path).items()}
    assert found == {"jaw_open": 2, "neutral": 2, "t05": 1}


@pytest.mark.parametrize("name", ["IMG_{}", "DSC0{}", "{}", "P10{}", "PXL_{}"])
def test_photographs_as_cameras_name_them_are_one_pose(tmp_path, name):
    for number in (1, 2):
        write(tmp_path / "anna" / f"{name.format(number)}.jpg", skin())
    assert list(find_poses(tmp_path / "anna")) == ["anna"]


def test_folders_without_photographs_say_what_is_there(tmp_path):
    with pytest.raises(FileError, match="no such folder"):
        find_poses(tmp_path / "nowhere")
    (tmp_path / "IMG_1.CR2").write_bytes(b"II*\0")
    with pytest.raises(FileError, match="develop"):
        find_poses(tmp_path)
    write(tmp_path / "a_1.jpg", skin())
    write(tmp_path / "b" / "a_1.jpg", skin())
    with pytest.raises(FileError, match="folders below"):
        find_poses(tmp_path)


def test_focal_lengths_in_pixels():
    by_film = read_exif(exif(FocalLengthIn35mmFilm=50), (3000, 2000))
    assert by_film.focal == pytest.approx(50 / 36 * 3000)
    # A Canon EOS 5D, 36 mm wide, of which a quarter of the pixels is left.
    by_sensor = read_exif(
        exif(
            FocalLength=50.0,
            FocalPlaneXResolution=3086.9258,
            FocalPlaneResolutionUnit=2,
            ExifImageWidth=4368,
            ExifImageHeight=2912,
        ),
        (1092, 728),
    )
    assert by_sensor.focal == pytest.approx(50 / 35.94 * 1092, rel=1e-3)
    assert read_exif(exif(FocalLength=50.0), (1092, 728)).focal is None
    assert read_exif(exif(), (1092, 728)) == Exif()


@pytest.mark.parametrize(
    "tags",
    [
        {"FocalLengthIn35mmFilm": 2},
        {"FocalLengthIn35mmFilm": 4000},
        {"FocalLength": 50.0, "FocalPlaneXResolution": 3.0},
        {"FocalLength": 50.0, "FocalPlaneXResolution": 1e6},
    ],
)
def test_absurd_focal_lengths_are_doubted(tags):
    found = read_exif(exif(**tags), (3000, 2000))
    assert found.focal is None
    assert found.doubt


@pytest.mark.parametrize(
    "value", ["", "a", TiffImagePlugin.IFDRational(1, 0), -3, 0, float("nan"), (1, 2)]
)
def test_damaged_focal_lengths_are_none(value):
    tags = exif()
    tags.get_ifd(ExifTags.IFD.Exif)[BASE.FocalLengthIn35mmFilm] = value
    assert read_exif(tags, (3000, 2000)).focal is None


@pytest.mark.parametrize("orientation", range(1, 9))
@pytest.mark.parametrize("suffix", [".png", ".tif", ".jpg"])
def test_pixels_are_upright(tmp_path, orientation, suffix):
    path = tmp_path / f"a{suffix}"
    stored = Image.fromarray(skin())
    options = {"quality": 100, "subsampling": 0} if suffix == ".jpg" else {}
    stored.save(path, exif=exif(Orientation=orientation), **options)
    with Image.open(path) as image:
        expected = np.asarray(ImageOps.exif_transpose(image).convert("RGB"))
    np.testing.assert_array_equal(read_upright(path), expected)
    taken = examine("a", [path], fewest=1).taken[0]
    assert taken.size == expected.shape[1::-1]
    assert read_upright(path, grey=True).shape == expected.shape[:2]


def test_sixteen_bits_keep_their_brightness(tmp_path):
    values = (np.arange(70 * 70, dtype=np.uint16) * 13).reshape(70, 70)
    Image.fromarray(values).save(tmp_path / "a.tif")
    found = read_upright(tmp_path / "a.tif", grey=True)
    np.testing.assert_allclose(found, values / 257.0, atol=0.51)


def test_a_good_pose(twelve):
    found = examine("smile", twelve)
    assert [photograph.path for photograph in found.taken] == twelve
    assert not found.rejected
    assert not found.remarks
    assert found.taken[0].focal == pytest.approx(50 * 200 / np.hypot(36, 24))


def test_heic_is_refused_with_a_hint(tmp_path, twelve):
    heic = twelve[0].with_name("IMG_99.HEIC")
    heic.write_bytes(b"\0\0\0\x18ftypheic\0\0\0\0mif1heic" + bytes(100))
    assert heic in find_poses(tmp_path)["smile"]
    with pytest.raises(FormatError, match="convert it to JPEG"):
        examine("smile", [*twelve, heic])
    renamed = heic.rename(heic.with_name("IMG_99.jpg"))
    with pytest.raises(FormatError, match="convert it to JPEG"):
        examine("smile", [*twelve, renamed])


def test_heic_beside_its_jpeg_is_no_photograph_of_its_own(twelve):
    twelve[0].with_suffix(".heic").write_bytes(b"\0\0\0\x18ftypheic")
    assert list(find_poses(twelve[0].parent)["smile"]) == twelve


def test_damaged_files_are_left_out(twelve):
    whole = twelve[0].read_bytes()
    twelve[0].write_bytes(whole[: len(whole) // 2])
    twelve[1].write_bytes(b"")
    twelve[2].write_bytes(b"no photograph")
    found = examine("smile", twelve)
    assert list(found.rejected) == ["IMG_0.jpg", "IMG_1.jpg", "IMG_2.jpg"]
    assert "copy it again" in found.rejected["IMG_0.jpg"]
    assert "empty" in found.rejected["IMG_1.jpg"]
    assert len(found.taken) == 9


def test_one_photograph_twice(twelve):
    copy = shutil.copy(twelve[3], twelve[3].with_name("copy_1.jpg"))
    found = examine("smile", [*twelve, Path(copy)])
    assert found.rejected == {"copy_1.jpg": "it is the same file as IMG_3.jpg"}


def test_one_photograph_stored_again(twelve):
    """Without its EXIF, or with more loss: the one that says more is kept."""
    place = twelve[0].parent
    Image.open(twelve[1]).save(place / "A.jpg", quality=75)
    Image.open(twelve[2]).save(place / "B.png")
    found = examine("smile", sorted(place.iterdir()))
    assert found.rejected == {
        "A.jpg": "it is the same photograph as IMG_1.jpg, stored again",
        "B.png": "it is the same photograph as IMG_2.jpg, stored again",
    }


def test_poses_are_compared_by_sharpness(twelve):
    sharp = examine("neutral", twelve)
    for width, told in ((1.2, "its photographs are blurred: "), (4.0, None)):
        for k, path in enumerate(twelve):
            blurred = gaussian_filter(skin(k), (width, width, 0))
            write(path, blurred, Model="X1", FocalLengthIn35mmFilm=50)
        poses = {"neutral": sharp, "smile": examine("smile", twelve)}
        if told is None:
            with pytest.raises(CaptureError, match=r"'smile': its photographs.* leave it out"):
                compared(poses)
        else:
            assert compared(poses)["smile"].startswith(told)
            assert list(compared(poses)) == ["smile"]
    assert compared({"neutral": sharp}) == {}


def test_a_photograph_is_of_one_pose(twelve):
    neutral, smile = examine("neutral", twelve[:7]), examine("smile", twelve[6:])
    with pytest.raises(CaptureError, match=r"'smile': IMG_6\.jpg is the same file as IMG_6\.jpg"):
        compared({"neutral": neutral, "smile": smile})


def test_blurred_photographs_are_left_out(twelve):
    blurred = gaussian_filter(skin(7), (2.5, 2.5, 0))
    write(twelve[7], blurred, Model="X1", FocalLengthIn35mmFilm=50)
    found = examine("smile", twelve)
    assert list(found.rejected) == ["IMG_7.jpg"]
    assert "blurred" in found.rejected["IMG_7.jpg"]


def test_most_of_a_pose_may_be_blurred(twelve):
    for k in range(8):
        blurred = gaussian_filter(skin(k), (2.5, 2.5, 0))
        write(twelve[k], blurred, Model="X1", FocalLengthIn35mmFilm=50)
    with pytest.raises(CaptureError, match=r"has 4 photographs of use out of 12.*IMG_0.*blurred"):
        examine("smile", twelve)


def test_sharpness_does_not_depend_on_brightness():
    grey = skin(1)[..., 0]
    assert sharpness(grey // 2) == pytest.approx(sharpness(grey), rel=0.05)
    blurred = gaussian_filter(grey, 2)
    assert sharpness(blurred) < 0.5 * sharpness(grey)
    assert sharpness(np.full((100, 100), 128, dtype=np.uint8)) == 0


@pytest.mark.parametrize("noise", [0.0, 2.0, 5.0, 8.0])
def test_blur_is_seen_beneath_noise(noise):
    """Noise is neither taken for detail nor for its lack."""
    random = np.random.default_rng(3)
    clean = 128 + 0.35 * (skin(1, (320, 240))[..., 0] - 128.0)  # as little contrast as skin has

    def stored(width: float) -> np.ndarray:
        noisy = gaussian_filter(clean, width) + noise * random.normal(size=clean.shape)
        return np.clip(np.round(noisy), 0, 255).astype(np.uint8)

    assert sharpness(stored(0)) == pytest.approx(sharpness(clean.astype(np.uint8)), rel=0.08)
    assert sharpness(stored(2)) < 0.5 * sharpness(stored(0))
    assert sharpness(stored(3)) < 0.4 * sharpness(stored(0))


def test_a_blurred_photograph_of_a_dim_room_is_left_out(twelve):
    """It is the one with most fine detail, all of it noise."""
    noise = 20 * np.random.default_rng(3).normal(size=skin(7).shape[:2])[..., None]
    blurred = gaussian_filter(skin(7).astype(np.float64), (3, 3, 0))
    pixels = np.clip(blurred + noise, 0, 255).astype(np.uint8)
    write(twelve[7], pixels, Model="X1", FocalLengthIn35mmFilm=50)
    assert list(examine("smile", twelve).rejected) == ["IMG_7.jpg"]


def test_photographs_of_another_camera_are_left_out(twelve):
    write(twelve[2], skin(2, (150, 120)), Model="X1", FocalLengthIn35mmFilm=50)
    write(twelve[4], skin(4), Model="Other", FocalLengthIn35mmFilm=50)
    found = examine("smile", twelve)
    assert set(found.rejected) == {"IMG_2.jpg", "IMG_4.jpg"}
    assert "another camera, lens or size" in found.rejected["IMG_4.jpg"]
    write(twelve[4], skin(4, (120, 160)), Model="X1", FocalLengthIn35mmFilm=50)
    assert (
        examine("smile", twelve)
        .rejected["IMG_4.jpg"]
        .endswith("; turn those upright that lie on their side")
    )


def test_photographs_that_lost_their_exif_are_of_the_camera_of_the_others(twelve):
    for k in (1, 5, 6):
        write(twelve[k], skin(k))
    found = examine("smile", twelve)
    assert not found.rejected
    assert len({photograph.lens for photograph in found.taken}) == 1
    assert [photograph.focal is None for photograph in found.taken].count(True) == 3


def test_two_cameras_that_took_many_are_both_used(twelve):
    for k in range(6):
        write(twelve[k], skin(k), Model="Other", FocalLengthIn35mmFilm=30)
    found = examine("smile", twelve)
    assert len(found.taken) == 12
    assert len({photograph.lens for photograph in found.taken}) == 2
    assert any("several cameras" in remark for remark in found.remarks)


def test_too_few_photographs(twelve):
    with pytest.raises(CaptureError, match=r"5 photographs of use out of 5, at least 6.*25 to 30"):
        examine("smile", twelve[:5])


def test_photographs_without_focal_length_are_mentioned(tmp_path):
    paths = [write(tmp_path / f"{k}.jpg", skin(k)) for k in range(8)]
    assert "8 of 8 photographs have no focal length" in examine("a", paths).remarks[0]


def test_masks_by_name(tmp_path, twelve):
    masks = tmp_path / "m"
    white = np.zeros((120, 160, 3), dtype=np.uint8)
    white[30:90, 40:120] = 255
    for path in twelve[:6]:
        write(masks / "smile" / f"{path.stem}.png", white)
    write(masks / "smile" / "IMG_6.jpg.png", white)
    found = find_masks(masks, {"smile": twelve})
    assert list(found) == twelve[:7]
    taken = examine("smile", twelve, masks=found)
    assert "5 of 12 photographs have no mask" in taken.remarks
    np.testing.assert_array_equal(read_mask(found[twelve[0]], (160, 120)), white[..., 0] > 0)


def test_masks_that_are_not_of_their_photographs(tmp_path, twelve):
    with pytest.raises(FileError, match="no such folder of masks"):
        find_masks(tmp_path / "m", {"smile": twelve})
    other = write(tmp_path / "m" / "other.png", skin())
    with pytest.raises(FileError, match=r"named as a photograph, such as IMG_0\.png"):
        find_masks(tmp_path / "m", {"smile": twelve})
    for size, text in (((80, 60 + 4), "same size"), ((120, 160), "on its side")):
        write(other, skin(0, size))
        with pytest.raises(FormatError, match=text):
            examine("smile", twelve, masks={twelve[0]: other})
    write(other, np.zeros((120, 160, 3), dtype=np.uint8))
    with pytest.raises(FormatError, match="black all over"):
        examine("smile", twelve, masks={twelve[0]: other})
