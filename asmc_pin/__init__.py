"""Verify, design and compare time-delay-estimation control of robot arms on a Pinocchio ground truth.

The public names load on first use, so that importing the package, or asking the command line for help, stays quick.
"""

from __future__ import annotations

from asmc_pin.lazy import load_on_first_use

TYPE_CHECKING = False  # without the cost of importing typing

if TYPE_CHECKING:
    from asmc_pin.agreement import AgreementReport as AgreementReport
    from asmc_pin.agreement import agree as agree
    from asmc_pin.arms import Arm as Arm
    from asmc_pin.arms import Payload as Payload
    from asmc_pin.arms import arm_names as arm_names
    from asmc_pin.arms import load_arm as load_arm
    from asmc_pin.arms.arm_options import Unchanged as Unchanged
    from asmc_pin.arms.sources.robot_files import RobotFiles as RobotFiles
    from asmc_pin.arms.urdf.urdf_reading import Mimic as Mimic
    from asmc_pin.baselines import BASELINES as BASELINES
    from asmc_pin.baselines import ModelLaw as ModelLaw
    from asmc_pin.condition import Bound as Bound
    from asmc_pin.condition import BoundsReport as BoundsReport
    from asmc_pin.condition import ConditionReport as ConditionReport
    from asmc_pin.condition import Recording as Recording
    from asmc_pin.condition import bounds as bounds
    from asmc_pin.condition import certified as certified
    from asmc_pin.condition import design as design
    from asmc_pin.condition import lemma1_norm as lemma1_norm
    from asmc_pin.condition import read_recording as read_recording
    from asmc_pin.condition import verify as verify
    from asmc_pin.condition import weighted_norm as weighted_norm
    from asmc_pin.condition.best_mbar.design_report import ArmaturePurchase as ArmaturePurchase
    from asmc_pin.condition.best_mbar.design_report import DesignBranch as DesignBranch
    from asmc_pin.condition.best_mbar.design_report import DesignLimit as DesignLimit
    from asmc_pin.condition.best_mbar.design_report import DesignPoint as DesignPoint
    from asmc_pin.condition.best_mbar.design_report import DesignReport as DesignReport
    from asmc_pin.condition.best_mbar.design_report import WeightedDesign as WeightedDesign
    from asmc_pin.condition.best_mbar.exchange import DesignProgress as DesignProgress
    from asmc_pin.condition.certificate import CertificateResult as CertificateResult
    from asmc_pin.condition.certificate import ProofProgress as ProofProgress
    from asmc_pin.condition.certificate import certify as certify
    from asmc_pin.condition.checker import CheckedStatement as CheckedStatement
    from asmc_pin.condition.checker import CheckResult as CheckResult
    from asmc_pin.condition.checker import check as check
    from asmc_pin.condition.checker.bounds_conclusion import BoundsConclusion as BoundsConclusion
    from asmc_pin.condition.checker.conclusions import Conclusion as Conclusion
    from asmc_pin.condition.checker.loop_conclusion import LoopConclusion as LoopConclusion
    from asmc_pin.condition.checker.spot_checks import Spots as Spots
    from asmc_pin.condition.hypotheses import Carried as Carried
    from asmc_pin.condition.hypotheses import Hypotheses as Hypotheses
    from asmc_pin.condition.hypotheses import Premises as Premises
    from asmc_pin.condition.search.what_would_help import WhatWouldHelp as WhatWouldHelp
    from asmc_pin.controllers import CONTROLLERS as CONTROLLERS
    from asmc_pin.controllers import AdaptiveState as AdaptiveState
    from asmc_pin.controllers import Choice as Choice
    from asmc_pin.controllers import Controller as Controller
    from asmc_pin.controllers import OptionalScalar as OptionalScalar
    from asmc_pin.controllers import PerJoint as PerJoint
    from asmc_pin.controllers import Sample as Sample
    from asmc_pin.controllers import Scalar as Scalar
    from asmc_pin.controllers import ScalarOrWord as ScalarOrWord
    from asmc_pin.controllers import Setpoint as Setpoint
    from asmc_pin.controllers import TdeLaw as TdeLaw
    from asmc_pin.controllers import TdeState as TdeState
    from asmc_pin.controllers import signed as signed
    from asmc_pin.engine import LimitViolation as LimitViolation
    from asmc_pin.engine import Rollout as Rollout
    from asmc_pin.engine import rollout as rollout
    from asmc_pin.errors import ArmError as ArmError
    from asmc_pin.errors import AsmcPinError as AsmcPinError
    from asmc_pin.errors import ExperimentError as ExperimentError
    from asmc_pin.errors import MissingDependencyError as MissingDependencyError
    from asmc_pin.errors import NotComparableError as NotComparableError
    from asmc_pin.errors import NotPositiveDefinite as NotPositiveDefinite
    from asmc_pin.errors import ParameterError as ParameterError
    from asmc_pin.errors import ResultError as ResultError
    from asmc_pin.experiment import Experiment as Experiment
    from asmc_pin.experiment import experiment_names as experiment_names
    from asmc_pin.experiment import load_experiment as load_experiment
    from asmc_pin.experiment.variation.axes import Variation as Variation
    from asmc_pin.experiment.variation.axes import VariedKey as VariedKey
    from asmc_pin.experiment.variation.draws import Distribution as Distribution
    from asmc_pin.inspection import Doubt as Doubt
    from asmc_pin.inspection import Inspection as Inspection
    from asmc_pin.inspection import inspect as inspect
    from asmc_pin.inspection.inspection_report import InspectedJoint as InspectedJoint
    from asmc_pin.metrics import METRICS as METRICS
    from asmc_pin.metrics import Metric as Metric
    from asmc_pin.metrics import MetricSettings as MetricSettings
    from asmc_pin.metrics import evaluate as evaluate
    from asmc_pin.pages.sweeps.sweep_findings import Compared as Compared
    from asmc_pin.pages.sweeps.sweep_findings import SweepFindings as SweepFindings
    from asmc_pin.pages.tables.text_table import Table as Table
    from asmc_pin.parameters import AsGiven as AsGiven
    from asmc_pin.parameters import OptionalPerJoint as OptionalPerJoint
    from asmc_pin.parameters import PerTrial as PerTrial
    from asmc_pin.parameters import Values as Values
    from asmc_pin.plant import Disturbance as Disturbance
    from asmc_pin.plant import Drive as Drive
    from asmc_pin.plant import EndStops as EndStops
    from asmc_pin.plant import Friction as Friction
    from asmc_pin.plant import Motion as Motion
    from asmc_pin.plant import MovingArm as MovingArm
    from asmc_pin.plant import PayloadChange as PayloadChange
    from asmc_pin.plant import Plant as Plant
    from asmc_pin.plant import PlantParameters as PlantParameters
    from asmc_pin.plant import Sensor as Sensor
    from asmc_pin.plant import Spread as Spread
    from asmc_pin.plant import VelocityTerm as VelocityTerm
    from asmc_pin.references import REFERENCES as REFERENCES
    from asmc_pin.references import Reference as Reference
    from asmc_pin.reproduction.reproducing import Reproduction as Reproduction
    from asmc_pin.reproduction.reproducing import reproduce as reproduce
    from asmc_pin.results.result_folder import Result as Result
    from asmc_pin.results.result_folder import load_result as load_result
    from asmc_pin.sampled import LoopLimits as LoopLimits
    from asmc_pin.sampled import LoopNoise as LoopNoise
    from asmc_pin.sampled import LoopProof as LoopProof
    from asmc_pin.sampled import LoopSensor as LoopSensor
    from asmc_pin.sampled import SampledLoop as SampledLoop
    from asmc_pin.sampled import StabilityReport as StabilityReport
    from asmc_pin.sampled import certify_loop as certify_loop
    from asmc_pin.sampled import loop_sensor as loop_sensor
    from asmc_pin.sampled import stability as stability
    from asmc_pin.sampled.gain_choice.gain_design import ExpectedErrors as ExpectedErrors
    from asmc_pin.sampled.gain_choice.gain_design import GainDesign as GainDesign
    from asmc_pin.sampled.gain_choice.gain_search import Margins as Margins
    from asmc_pin.sampled.gain_choice.gains import suggest_gains as suggest_gains
    from asmc_pin.sampled.stability_report import WorstFound as WorstFound
    from asmc_pin.statistics.pairwise import PairedComparison as PairedComparison
    from asmc_pin.study import Comparison as Comparison
    from asmc_pin.study import compare as compare
    from asmc_pin.study.comparison_notes import Lemma1Part as Lemma1Part
    from asmc_pin.study.comparison_notes import Lemma1Range as Lemma1Range
    from asmc_pin.study.refinement import Refinement as Refinement
    from asmc_pin.study.run_monitors import Theorems as Theorems
    from asmc_pin.study.viewing import view as view
    from asmc_pin.sweeping import Sweep as Sweep
    from asmc_pin.sweeping import sweep as sweep
    from asmc_pin.tool_error import ToolError as ToolError
    from asmc_pin.words.provisos import Proviso as Proviso

__getattr__, __dir__, __all__ = load_on_first_use(__name__)
