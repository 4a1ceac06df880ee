#!/usr/bin/env python3
"""The suite's own test: each misbehaviour of bad_delegate fails the tests that TABLE names, and no other.

  misbehaviours.py PROGRAM BAD_LIBRARY [--each] [NAME...]

Misbehaviours whose tests differ share a run, which must fail the tests of them all. --each gives each its own run. Where a
misbehaviour is a race, MAY names tests that some runs fail.
"""
import argparse
import fnmatch
import os
import re
import subprocess
import sys

WINDOWS = ["Of/Windows.*/color", "Of/Windows.*/primId"]
TABLE = {
    "a_failure_never_converges": ["Convergence.AFailureConverges", "Convergence.AfterAFailureTheNextFrameIsDrawn",
                                  "Resume.AnotherSceneIsRefused", "Windows.UndrawableWindowsFailWithAReason"],
    "a_stop_converges": ["Control.TenThousandStopsAndStarts", "Convergence.AStoppedRenderHasNotConverged"],
    "allocates_anything": ["Buffers.ImpossibleSizesAreRefusedAndChangeNothing"],
    "an_edit_ends_a_pause": ["Sync.WaitsForNoRender"],
    "averages_depth": ["Buffers.EveryAovOfAViewportIsThere", "Depth.IsOneWhereNothingIsAndThatOfTheClosestSample"],
    "averages_ids": ["Ids.AreNeverAveraged", "Of/Windows.A*/primId", "Instances.AHiddenPrototypeHasNone",
                     "Instances.AnInstancerMayHaveNone", "Instances.IndicesOutOfRangeAreLeftOutAndKeepTheirNumbers",
                     "Instances.InstancersComeAndGoInAnyOrder", "Instances.NestedOnesHaveTheirPlaceAndId",
                     "Instances.TheOrderIs*", "Purposes.PurposesOfNestedInstancesAreToggled"],
    "background_is_zero": ["Ids.AreNeverAveraged", "Ids.ZeroIsAnIdAndTheBackgroundIsMinusOne", "Instances.*",
                           "Purposes.PurposesOfNestedInstancesAreToggled"],
    "buffers_never_converge": ["Convergence.BuffersAndPassAgree"],
    "converges_before_the_last_picture": ["Convergence.TheLastPictureIsSeenBeforeItIsReported",
                                          "Convergence.BuffersAndPassAgree", "DelegateSettings.AnotherValueRestarts"],
    "describes_settings_that_no_host_shows": ["DelegateSettings.DescriptorsHaveValuesThatHostsCanShow"],
    "does_not_pause": ["Control.APauseParksTheWorkers"],
    "draws_a_ghost_of_no_instance": ["Instances.AnInstancerMayHaveNone"],
    "draws_prototypes": ["Instances.*", "Purposes.PurposesOfNestedInstancesAreToggled"],
    "drops_faces_of_no_subset": ["Subsets.FacesOfNoSubsetHaveTheMeshsMaterial", "Subsets.MayBeMany"],
    "drops_samples_outside_of_the_shutter": ["MovingPrims.SamplesMayLieOutsideOfTheShutter"],
    "drops_unknown_settings": ["DelegateSettings.UnknownKeysAreKeptAndIgnored"],
    "empty_after_restart": ["Buffers.TheFirstPictureAfterARestartIsNotEmpty",
                            "Buffers.TheOldPictureStaysUntilTheNewOneCovers"],
    "fails_once_a_mesh_is_bad": ["*BadMesh*/CountsWithoutIndices", "*BadMesh*/FewerIndicesThanCounts", "*BadMesh*/HugeCount",
                                 "*BadMesh*/IndicesWithoutCounts", "*BadMesh*/MoreIndicesThanCounts",
                                 "*BadMesh*/NegativeCount"],
    "flips_rows": ["Buffers.RowsRunBottomUp", "Ids.ElementsAreFacesOfTheCage", "Instances.*", "Meshes.HolesAreHoles",
                   "Of/Windows.*", "Primvars.MayChangeTheirInterpolationAndType", "Primvars.PointsAloneMayChange",
                   "Purposes.PurposesOfNestedInstancesAreToggled", "Subsets.*", "Sync.WaitsForNoRender", "Visibility.EditsOfAHiddenMeshAreSeenOnceItIsShown"],
    "generation_always_rises": ["Buffers.TheGenerationRisesOnlyWithNewPixels", "Execute.NothingThatStaysTheSameRestarts",
                                "DelegateSettings.AnEqualValueRestartsNothing"],
    "has_no_fallbacks": ["Prims.FallbacksAreNeverSyncedAndHarmNothing"],
    "ignores_clear_values": ["Windows.OutsideTheDataWindowIsTheClearValue"],
    "ignores_collections": ["Collections.ChooseByPath"],
    "ignores_free_cameras": ["CameraPrim.FreeCameraIsUsed"],
    "ignores_holes": ["Meshes.HolesAreHoles"],
    "ignores_light_links": ["LightCategories.NameCategories"],
    "ignores_motion_at_first": ["MovingPrims.SamplesMayLieOutsideOfTheShutter", "MovingPrims.TheCameraIsBlurred",
                                "MovingPrims.TheFirstFrameIsBlurred"],
    "ignores_orientation": ["Meshes.SingleSidedFacesAreSeenFromTheFront"],
    "ignores_rebinding": ["MaterialPrims.MayBeReboundAlone", "RapidEdits.NoEditIsLost", "*BadMesh*/EmptyArrays",
                          "*BadMesh*/MaterialThatDoesNotExist"],
    "ignores_settings": ["DelegateSettings.AnotherValueRestarts"],
    "ignores_shutter_changes": ["MovingPrims.AShutterChangeNeedsNoSyncOfMeshes"],
    "ignores_sides": ["Meshes.SingleSidedFacesAreSeenFromTheFront"],
    "ignores_the_passes_purposes": ["Purposes.PurposesAreToggledWithoutASync", "Purposes.PurposesOfNestedInstancesAreToggled"],
    "ignores_visibility": ["Instances.AHiddenPrototypeHasNone", "MaterialPrims.MayBeEditedWhileTheirMeshIsHidden",
                           "Visibility.*"],
    "instance_ids_outermost_fastest": ["Instances.NestedOnesHaveTheirPlaceAndId"],
    "is_slow_to_stop": ["Control.StopIsSeenSoon"],
    "keeps_interpolations": ["Primvars.MayChangeTheirInterpolationAndType"],
    "keeps_its_first_size": ["Buffers.AMappingSurvivesAResizeThatIsDrawn", "Buffers.ImpossibleSizesAreRefusedAndChangeNothing",
                             "Buffers.TheOldPictureStaysUntilTheNewOneCovers"],
    "keeps_old_networks": ["MaterialPrims.MayBeEditedWhileTheirMeshIsHidden", "MaterialPrims.MayChangeTheirNetwork",
                           "MaterialPrims.BrokenMaterialHarmsNoOther", "RapidEdits.NoEditIsLost",
                           "RapidEdits.ControlFromOtherThreadsLosesNoEdit"],
    "keeps_old_points": ["Primvars.PointsAloneMayChange"],
    "keeps_old_purposes": ["Purposes.ChangedPurposeOfAMeshIsDrawn"],
    "keeps_old_prim_ids": ["Ids.ANewPrimIdIsSeen"],
    "keeps_quiet_about_failures": ["Convergence.AFailureConverges", "Resume.AnotherSceneIsRefused"],
    "keeps_removed_primvars": ["Primvars.RemovedPrimvarsAreNotDrawn"],
    "lacks_a_statistic": ["Stats.HaveTheKeysThatHostsAskForAtAnyTime"],
    "leaks_edits": ["RapidEdits.MemoryDoesNotGrowWithEdits"],
    "leaves_bits_dirty": ["Sync.LeavesNoBitsDirty"],
    "loses_edits_while_rendering": ["RapidEdits.NoEditIsLost", "RapidEdits.NoInstanceIsLost",
                                    "RapidEdits.ControlFromOtherThreadsLosesNoEdit", "RapidEdits.TheLastOfTwoEditsIsDrawn"],
    "makes_any_type": ["Prims.UnknownTypesOfPrimsAreNull"],
    "moves_crops": WINDOWS,
    "one_delegates_end_stops_all": ["Delegates.DelegateMayEndWhileAnotherRenders", "Resume.GivesTheBytesOf*",
                                    "Resume.PartsAddUpToTheWhole"],
    "one_set_of_settings_for_all": ["Delegates.DelegatesShareNoSettings"],
    "pulls_everything": ["MaterialPrims.MayBeReboundAlone", "Sync.PullsNothingThatIsClean"],
    "resolves_materials_in_sync": ["MaterialPrims.MayComeAfterTheirMesh", "MaterialPrims.MayGoBeforeTheirMesh"],
    "restarts_on_equal_allocation": ["Buffers.AnEqualAllocationRestartsNothing"],
    "restarts_on_equal_setting": ["DelegateSettings.AnEqualValueRestartsNothing"],
    "restarts_on_every_sync": ["Execute.NothingThatStaysTheSameRestarts"],
    "resumes_anything": ["Resume.AnotherSceneIsRefused"],
    "resumes_from_zero": ["Control.APauseKeepsItsSamples"],
    "resumes_with_another_seed": ["Resume.AnotherSceneIsRefused", "Resume.GivesTheBytesOf*"],
    "reverses_instance_transforms": ["Instances.TheOrderIs*"],
    "scribbles_over_mapped_pixels": ["Buffers.AMappingSurvivesAResizeThatIsDrawn", "Buffers.AMappingSurvivesAllocate"],
    "seed_is_of_the_delegate": ["Bytes.AnotherDelegateGivesTheSameBytes", "Bytes.DoNotDependOnTheOrderOfSync",
                                "Bytes.MoreSamplesContinueToThoseOfOneRender", "Bytes.ManyThreadsGiveTheBytesOfOne",
                                "Control.*", "Delegates.*", "MovingPrims.AShutterChangeNeedsNoSyncOfMeshes",
                                "Of/Windows.ABufferMayHaveTheCropsSize/*", "Of/Windows.Overscan*", "Resume.*", "RapidEdits.*",
                                "Sync.ParallelSyncGivesTheBytesOfOneThread"],
    "seed_is_of_the_edits": ["Bytes.AnotherDelegateGivesTheSameBytes", "Bytes.DoNotDependOnEditsBefore",
                             "Execute.NothingThatStaysTheSameRestarts", "RapidEdits.NoEditIsLost",
                             "RapidEdits.ControlFromOtherThreadsLosesNoEdit"],
    "seed_is_of_the_threads": ["Bytes.AnotherDelegateGivesTheSameBytes", "Bytes.ManyThreadsGiveTheBytesOfOne"],
    "shows_the_first_part_alone": ["Resume.PartsAddUpToTheWhole"],
    "size_is_ahead_of_pixels": ["Buffers.SizeAndPixelsAreReadAsOne"],
    "stop_does_not_latch": ["Control.StopLatchesUntilRestart"],
    "takes_255_subsets": ["Subsets.MayBeMany"],
    "takes_any_aov": ["Buffers.EveryAovOfAViewportIsThere"],
    "takes_any_version": ["Delegates.DelegateOfAnotherVersionIsNotMade"],
    "takes_the_hosts_workers": ["Workers.ALoopOfTheHostHasAllItsThreadsWhileARenderGoesOn"],
}
MAY = {"restarts_on_every_sync": ["Resume.PartsAddUpToTheWhole"]}
# Some mend or worsen others.
ALONE = {"ignores_motion_at_first", "pulls_everything",
         *(name for name, tests in TABLE.items() if any("*" in test for test in tests) or len(tests) > 3)}


def groups(names):
    """Names that share no test, at most six together; those of ALONE by themselves."""
    found = []
    for name in names:
        fits = [g for g in found if len(g) < 6 and not ALONE & {name, *g}
                and not set(TABLE[name]) & {test for other in g for test in TABLE[other]}]
        if fits:
            fits[0].append(name)
        else:
            found.append([name])
    return found


def failures(program, library, names):
    """The tests that fail; None where the program does not come to its end."""
    environment = {**os.environ, "CONFORMANCE_BAD": ",".join(names), "CONFORMANCE_REPEAT": "0.01"}
    run = subprocess.run([program, "--library", library, "--gtest_brief=1"], env=environment, capture_output=True, text=True)
    if run.returncode not in (0, 1):
        return None, f"exit status {run.returncode}\n" + (run.stdout + run.stderr)[-1000:]
    failed = re.findall(r"^\[  FAILED  \] ([^\s,]+)", run.stdout, re.M)
    return {name for name in failed if "." in name}, run.stdout


def faults(names, failed):
    expected = [test for name in names for test in TABLE[name]]
    allowed = expected + [test for name in names for test in MAY.get(name, [])]
    yield from (f"{test} passes" for test in expected if not fnmatch.filter(failed, test))
    yield from (f"{test} fails" for test in sorted(failed) if not any(fnmatch.fnmatch(test, one) for one in allowed))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("library")
    parser.add_argument("--each", action="store_true")
    parser.add_argument("names", nargs="*", default=[])
    arguments = parser.parse_args()
    names = arguments.names or list(TABLE)
    if len(os.sched_getaffinity(0)) == 1 and "takes_the_hosts_workers" in names:
        names.remove("takes_the_hosts_workers")
        print("takes_the_hosts_workers: skipped, because TBB has no workers on one core")
    runs = [[], *([[name] for name in names] if arguments.each else groups(names))]
    status = 0
    for run in runs:
        failed, output = failures(arguments.program, arguments.library, run)
        wrong = ["it ends early:\n" + output] if failed is None else list(faults(run, failed))
        if wrong:
            status = 1
            print(", ".join(run) or "no misbehaviour", *wrong, sep="\n  ")
    print(f"{len(names)} misbehaviours in {len(runs)} runs" + ("" if status else ": each fails the tests of its row"))
    return status


if __name__ == "__main__":
    sys.exit(main())
