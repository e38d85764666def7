"""Files as laboratories export them: the same numbers, or one sentence that says what to do."""

import os

import pytest

from laboratory_files import FILES, imported, problem


@pytest.mark.parametrize("one", FILES, ids=lambda one: one["name"])
def test_the_numbers_are_the_same_or_a_sentence_says_what_to_do(one, tmp_path):
    one["write"](tmp_path / one["name"])
    answer, records = imported(os.path.abspath(os.environ["STICKSLIP"]), tmp_path, one)
    assert not problem(one, answer, records)
    if one["refused"]:
        assert not (tmp_path / (one["name"] + ".data")).exists()
    else:
        # What was guessed stands at the head of the dataset, too.
        notes = [line.split(": ", 1)[1] for line in answer.stdout.splitlines() if line.startswith(one["name"] + ": ")]
        head = (tmp_path / (one["name"] + ".data") / "dataset.toml").read_text()
        assert all(note in head for note in notes)


def test_there_are_sixty_files_and_more():
    assert len(FILES) >= 60
