"""Are these files one rig, and a sound one? What is found has a name, a place and a remedy."""

from elastomorph.doctor.checks.material import BeamSettings
from elastomorph.doctor.examination import Examination, Settings
from elastomorph.doctor.examining import examine, examine_rig
from elastomorph.doctor.files import examine_files
from elastomorph.doctor.findings import KINDS, SEVERITIES, Finding
from elastomorph.doctor.repair import Repair, repair
from elastomorph.doctor.report import as_document, as_text
from elastomorph.doctor.thresholds import Thresholds

__all__ = [
    "KINDS",
    "SEVERITIES",
    "BeamSettings",
    "Examination",
    "Finding",
    "Repair",
    "Settings",
    "Thresholds",
    "as_document",
    "as_text",
    "examine",
    "examine_files",
    "examine_rig",
    "repair",
]
