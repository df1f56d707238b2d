"""What `make demo` runs, from an empty folder."""

import pytest

from asmc_pin.cli import main


@pytest.mark.long
def test_the_demo_says_where_its_report_is_and_that_can_be_sent_by_mail(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as ended:
        main(["demo"])
    said = " ".join(capsys.readouterr().out.split())
    assert not ended.value.code
    assert "results/demo/report.html" in said
    assert (tmp_path / "results" / "demo" / "report.html").stat().st_size < 6e6
