"""CSV files: units become SI, interpolation is as stated, and each mistake has its line and column."""

import numpy as np
import pytest

import fvkit_granular as gr

GOOD = "# a survey\ndistance [km], z [m], phi [%], v [km/h]\n\n0, 10, 50, 36\n 0.1 ,5.5,40,-18\n0.25,1e0,0,0\n"


@pytest.fixture
def write(tmp_path):
    def make(text):
        path = tmp_path / "data.csv"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return path

    return make


def test_units_become_si(write):
    path = write(GOOD)
    z = gr.Profile.read(path, "z", "linear", along="distance")
    np.testing.assert_array_equal(z.x, [0.0, 100.0, 250.0])
    np.testing.assert_array_equal(z.values, [10.0, 5.5, 1.0])
    np.testing.assert_allclose(gr.Profile.read(path, "phi", "linear", "distance", "share").values, [0.5, 0.4, 0.0])
    np.testing.assert_allclose(gr.Profile.read(path, "v", "linear", "distance", "speed").values, [10.0, -5.0, 0.0])
    centimetres = gr.Profile.read(write("x [cm], h [mm]\n0, 10\n200, 20\n"), "h", "linear")
    np.testing.assert_allclose([centimetres.x, centimetres.values], [[0.0, 2.0], [0.01, 0.02]])


def test_interpolation_is_linear_or_constant_and_covers_the_rows_alone(write):
    path = write("x [m], h [m]\n0, 1\n2, 3\n4, 0\n")
    x = np.array([0.0, 0.5, 2.0, 3.0, 4.0])
    np.testing.assert_array_equal(gr.Profile.read(path, "h", "linear")(x), [1.0, 1.5, 3.0, 1.5, 0.0])
    np.testing.assert_array_equal(gr.Profile.read(path, "h", "constant")(x), [1.0, 1.0, 3.0, 3.0, 0.0])
    with pytest.raises(ValueError, match=r"data.csv: column `h` covers x from 0 to 4 m, but x from -1 to 2 m is needed: add rows"):
        gr.Profile.read(path, "h", "linear")(np.array([-1.0, 2.0]))
    with pytest.raises(ValueError, match="did you mean linear"):
        gr.Profile.read(path, "h", "linea")


def test_windows_files_are_read(write):
    path = write(b"\xef\xbb\xbf" + b"x [m],h [m]\r\n0,1\r\n1,2\r\n")
    np.testing.assert_array_equal(gr.Profile.read(path, "h", "linear").values, [1.0, 2.0])


@pytest.mark.parametrize(("text", "words"), [
    ("x [m], z [m]\n0, 1\n1, 1\n", ("column of", "must be one of x, z; got 'h'")),
    ("z [m], h [m]\n0, 1\n1, 1\n", ("must be one of z, h; got 'x'",)),
    ("x [m], h\n0, 1\n1, 1\n", ("line 1", "'h'", "`x [m], phi [-]`")),
    ("x [m]; h [m]\n0; 1\n", ("line 1", "separated by commas")),
    ("0, 1\n1, 1\n", ("line 1", "header")),
    ("x [m], h [m], h [m]\n0, 1, 1\n", ("line 1", "`h` is there twice")),
    ("x [m], h [ft]\n0, 1\n", ("column `h` must be a length in one of m, km, cm, mm; got h [ft]",)),
    ("x [s], h [m]\n0, 1\n", ("column `x` must be a length",)),
    ("x [m], h [m]\n0, 1\n\n# note\n1, high\n", ("line 5, column `h`", "no number: 'high'")),
    ("x [m], h [m]\n0, 1\n1,\n", ("line 3, column `h`", "no number: ''")),
    ("x [m], h [m]\n0, 1\n1, nan\n", ("line 3, column `h`", "finite")),
    ("x [m], h [m]\n-inf, 1\n1, 1\n", ("line 2, column `x`", "finite")),
    ("x [m], h [m]\n0, 1\n1,5, 2\n", ("line 3", "2 values are needed (x, h), got 3", "decimals by points")),
    ("x [m], h [m]\n0, 1\n2, 1\n# note\n2, 1\n", ("line 5, column `x`", "ascend, got 2 m after 2 m")),
    (b"x [m], h [m]\n0, 1\n1, \xb5\n", ("line 3", "UTF-8")),
    ("x [m], h [m]\n", ("a header such as", "got 1 lines")),
    ("", ("a header such as",)),
    ("#" * 10_000_001, ("larger than 10 MB",)),
])
def test_mistakes_have_their_place(text, words, write):
    with pytest.raises(ValueError, match=r"data.csv") as refusal:
        gr.Profile.read(write(text), "h", "linear")
    for word in words:
        assert word in str(refusal.value)


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"there is no file .*nothing\.csv"):
        gr.Profile.read(tmp_path / "nothing.csv", "h", "linear")


HILLS = [0.0, 12.5, 40.0, 33.0, 51.0]


def survey(values, header="x [m], b [m]"):
    return "\n".join([header, *(f"{10 * k}, {value!r}" for k, value in enumerate(values))]) + "\n"


@pytest.mark.parametrize("code", [-9999.0, -32768.0, 32767.0, 1e20, 9.96921e36, 9.969209968386869e36, -3.4028234663852886e38, -999.0, -99999.0,
                                  9999.0, -1e30, 12345.0, -20000.0])
@pytest.mark.parametrize("row", [0, 2, 5])
def test_a_code_for_missing_values_is_no_elevation(code, row, write):
    path = write(survey([*HILLS[:row], code, *HILLS[row:]]))
    with pytest.raises(ValueError, match=rf"data.csv, line {row + 2}, column `b`: .* looks like a code for a missing value"):
        gr.Profile.read(path, "b", "linear")


@pytest.mark.parametrize(("values", "line"), [([*HILLS, -9999.0, -9999.0], 7), ([-9999.0, 1e20], 2), ([-9999.0, *HILLS, 1e20], 2)])
def test_many_codes_are_refused_at_the_first(values, line, write):
    with pytest.raises(ValueError, match=f"line {line}, column `b`"):
        gr.Profile.read(write(survey(values)), "b", "linear")


def test_codes_in_other_columns_are_refused_too(write):
    path = write("x [m], phi [%], v [m/s]\n0, 40, 1\n1, -9999, 2\n2, 50, -9999\n")
    for column, measures, line in (("phi", "share", 3), ("v", "speed", 4)):
        with pytest.raises(ValueError, match=f"line {line}, column `{column}`"):
            gr.Profile.read(path, column, "linear", measures=measures)
    with pytest.raises(ValueError, match="line 3, column `discharge`"):
        gr.Hydrograph.read(write("t [s], discharge [m2/s], phi [-]\n0, 1, 0.5\n999, -9999, 0.5\n"))


@pytest.mark.parametrize("values", [[0.0, 99.0], [-998.0, -999.0, -1010.0, -900.0], [-5000.0, -999.0, 10.0], [99.0, 100.0], [8848.0, 8000.0]])
def test_numbers_among_others_are_elevations(values, write):
    np.testing.assert_array_equal(gr.Profile.read(write(survey(values)), "b", "linear").values, values)


def scene_over(path):
    bottom = gr.Profile.read(path, "b", "linear")
    return gr.Scene((bottom.x[0], bottom.x[-1]), 1.0, lambda x: {"h": 1.0, "phi": 0.5}, bottom=bottom)


@pytest.mark.parametrize(("text", "fix"), [
    ("x [m], b [m]\n0, 0.8\n2500, 0.3\n5000, 0.0\n", "if `b` is in kilometres"), ("x [m], b [m]\n0, 2.412\n300, 2.3\n", "if `b` is in kilometres"),
    ("x [m], b [m]\n0, 800\n2.5, 300\n5, 0\n", "if x is in kilometres"), ("x [m], b [m]\n0, 0\n2, 30\n10, 200\n", "`b` in centimetres"),
    ("x [km], b [m]\n0, 0.8\n5, 0\n", "if `b` is in kilometres"), ("x [m], b [km]\n0, 0.8\n5, 0\n", "if x is in kilometres")])
def test_a_bottom_in_another_unit_than_its_header_says_is_noticed(text, fix, write):
    with pytest.warns(RuntimeWarning, match=rf"data.csv: the bottom `b` varies by .* m over .* m of x: .*{fix}.*say so in the header"):
        scene_over(write(text))


@pytest.mark.parametrize("text", [
    "x [m], b [m]\n0, 412\n120, 353\n800, 190\n", "x [km], b [km]\n0, 0.8\n5, 0\n", "x [m], b [m]\n0, 0\n5000, 0\n", "x [cm], b [mm]\n0, 3\n200, 0\n",
    "x [m], b [m]\n0, 412.3\n5000, 410.1\n", "x [m], b [m]\n0, 0.005\n10, 0\n", "x [m], b [m]\n0, 10\n0.01, 0\n50, 0\n"])
def test_plausible_bottoms_are_not_remarked_on(text, write):
    scene_over(write(text))


def test_an_interval_in_kilometres_beside_a_profile_in_metres_warns(write):
    path = write("x [km], b [m]\n0, 40\n2, 0\n")
    bottom = gr.Profile.read(path, "b", "linear")
    with pytest.warns(RuntimeWarning, match="the profile is 2000 m long and `interval` 2 m: if that is in kilometres"):
        gr.Scene((0.0, 2.0), 1.0, lambda x: {"h": 1.0, "phi": 0.5}, bottom=bottom)
