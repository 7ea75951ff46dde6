!> Thresholds of the search for a target. All numbers that its decisions compare with, in one place. Errors are parts of the target,
!> costs are counted work, eq. (7.97). "Measured": on the 101 searches of `bench/accuracy`. Floor: accuracy. Equations: doc/theory,
!> part 7.
module limber_accuracy_search_thresholds
   use limber_base_kinds, only: wp
   implicit none
   public

   ! --- Tolerances

   !> Largest tolerance of a search. Measured: above it RADAU steps over vibrations that a fifth of it does not follow either
   real(wp), parameter :: largest_tolerance = 1.0e-2_wp
   !> Least tolerance, and the least of a run that a smaller one can verify: round-off of double precision
   real(wp), parameter :: least_tolerance = 1.0e-13_wp, least_verified = 1.0e-12_wp
   !> Tolerance of a companion run over that of the run. Measured: a tenth cost 12 % more, a half showed too little
   real(wp), parameter :: companion_part = 0.2_wp
   !> Bounds of this ratio for a companion that is there already
   real(wp), parameter :: companion_bounds(2) = [0.01_wp, 0.41_wp]
   !> Tolerance below which RADAU follows axial vibrations: of a beam with a large axial force, and of others. Measured: cable and
   !> portal; slider_crank_heavy at 1e-2, whose strain looks harmless at 1e-2
   real(wp), parameter :: follows_strain = 1.0e-4_wp, shows_strain = 2.0e-3_wp
   !> Tolerance of ADAMS over the target, and the part of the work of RADAU that it may take. Measured: bang_bang_arm
   real(wp), parameter :: of_adams = 0.03_wp, cheaper = 1.0_wp/3

   ! --- Parts of the target

   !> Error of the integration that is too large, and one so small that the tolerance is made larger. Measured: with 0.06 the looser
   !> run mostly keeps 0.6
   real(wp), parameter :: time_too_large = 0.6_wp, time_little = 0.06_wp
   !> Part of an error that a smaller tolerance leaves if it does not help. Measured: slow falls of sudden loads leave less
   real(wp), parameter :: helped = 0.5_wp
   !> Error of the integration that a smaller tolerance can still mend
   real(wp), parameter :: time_matters = 0.1_wp
   !> Least error that a reference run of beams is taken to have. Measured: true errors beyond the estimated ones, up to 0.07
   real(wp), parameter :: doubt = 0.07_wp
   !> Error that a coarser setting may have; the rest is for errors of the reference run. Measured: 0.95 missed three targets
   real(wp), parameter :: coarse_enough = 0.9_wp
   !> Error of the models from which on the forecast counts as wrong
   real(wp), parameter :: noticed = 0.1_wp

   ! --- Models

   !> Part of an error that more functions leave if they do not help; beyond it the strain is measured. Measured: struck_beam, crane
   real(wp), parameter :: stalled = 0.7_wp
   !> What a level mostly divides the error by, and most levels in one step. Measured: two_wagons (4 took levels of no use)
   real(wp), parameter :: each_level = 8.0_wp
   integer, parameter :: most_levels = 3
   !> Error of the models over the target from which on more functions are needed for certain. Measured: two_wagons, panels
   real(wp), parameter :: clearly = 4.0_wp
   !> Difference from the reference over the target up to which the reference is improved, not the candidate. Measured: rotor,
   !> two_wagons
   real(wp), parameter :: room = 0.75_wp
   !> What one function of the strain shows is taken to be less than what all of it does by this factor. Measured: 0.85 to 1 of it,
   !> where it matters
   real(wp), parameter :: look_margin = 1.25_wp
   !> Work of the companion run over that of the candidate from which on the strain is looked at by the tolerance of the candidate
   !> first, and what that may show of the target to be enough. Measured: two_wagons, turbine_blade
   real(wp), parameter :: look_first = 1.5_wp, look_enough = 0.15_wp
   !> Ratio of tolerances up to which a measured error of the models counts for a smaller tolerance. Measured: two companion runs
   real(wp), parameter :: stale = 6.0_wp

   ! --- Costs

   !> Whole search over the run that it leaves, up to which it goes on: 15 is promised
   real(wp), parameter :: most_effort = 13.0_wp
   !> Power of the tolerance that work falls with. Measured: RADAU, 0.1 to 0.3
   real(wp), parameter :: work_power = 0.2_wp
   !> Part of the work that a coarser setting must save; that a level must be expected to save; that is always worth a run
   real(wp), parameter :: saved = 0.1_wp, worth = 0.05_wp, saves_much = 0.5_wp
   !> Work that every run may take: a second or two
   real(wp), parameter :: least_patience = 5.0e5_wp
   !> Expected work over that of the candidate up to which functions and strain are measured together. Measured: four_bar,
   !> slider_crank
   real(wp), parameter :: together = 6.0_wp
   !> Least error that functions and strain leave that are measured together, over what they change. Measured: slider_crank at 1e-3
   real(wp), parameter :: joint_rest = 0.3_wp
   !> Work of a run over that of the candidate after which it is given up: companion runs, higher levels, levels with strain or in
   !> place of a rigid beam, the next candidate
   real(wp), parameter :: patience_time = 60.0_wp, patience_model = 32.0_wp, patience_strain = 80.0_wp, patience_next = 100.0_wp
   !> Work that all runs together may take, some ten seconds, and beyond it over the first run, or over the last candidate if that
   !> takes
   !> about a second at most
   real(wp), parameter :: least_budget = 3.0e6_wp, most_first = 60.0_wp, second = 3.0e5_wp
   !> Part of forces that vibrations along beams make wrong from which on a search is given less, as such errors fall slowly: so
   !> many times the work of the first run, and none for a candidate that takes more than that. Measured: rods whose weight begins
   !> at once
   real(wp), parameter :: much_ringing = 5.0e-3_wp, most_ringing = 15.0_wp
   !> Most rounds of a search
   integer, parameter :: most_rounds = 200

   ! --- How errors fall

   !> Power of the tolerance: usual, and least where pairs of runs show less; part of the error that the usual power leaves
   real(wp), parameter :: usual_power = 0.6_wp, least_power = 0.15_wp, usually = 0.75_wp
   !> Factors of a larger tolerance: least and most
   real(wp), parameter :: looser(2) = [1.75_wp, 10.0_wp]
   !> Factor from which on a tolerance is made larger in one step
   real(wp), parameter :: far = 1.0e3_wp
   !> Looks at a target that is kept by chance, and the factor of the tolerance
   integer, parameter :: most_looks = 2
   real(wp), parameter :: look_factor = 0.1_wp

end module limber_accuracy_search_thresholds
