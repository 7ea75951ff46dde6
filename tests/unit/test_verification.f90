!> Parts of a search for a target: which rungs verify a beam, also where the probe has been wrong; runs that are there already;
!> what strain makes where nothing is known of it; and what beams are given that joints hold at both ends.
program test_verification
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_accuracy_advice, only: advice_type, check_rung, strained_rung, note_surprise
   use limber_accuracy_run_pool, only: pool_type
   use limber_accuracy_pilot_scenes, only: build_exact
   use limber_accuracy_fidelity_levels, only: level_type, find_rungs
   use limber_scene_scene, only: scene_type
   use limber_accuracy_candidate, only: candidate_type, run_request_type
   use limber_accuracy_search_steps, only: target_search_type, strain_step, weigh
   use limber_deck_content, only: deck_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_reader, only: read_deck_text
   use testing, only: check, check_close, check_no_error, finish
   implicit none
   character(*), parameter :: nl = new_line('a')

   call test_surprise()
   call test_kept_runs()
   call test_strain()
   call test_held_beams()
   call finish()

contains

   !> A beam of which a ten-thousandth of the target is expected is verified if it bends; a rigid one not before a run has shown ten
   !> times more. With 600 times the strain is verified too, for that was expected to be of the same size.
   subroutine test_surprise()
      type(advice_type) :: advice
      type(level_type) :: rung
      advice%target = 1.0e-2_wp
      advice%share = 0.65e-2_wp
      allocate (advice%rungs(1), advice%probe%beams(1))
      advice%rungs%open_functions = .true.
      advice%rungs%open_strains = .true.
      advice%rungs%step = 3
      advice%probe%beams(1)%effect = 1.0e-5_wp
      advice%probe%beams(1)%stretch = 1.0e-6_wp
      advice%expected = [1.0e-6_wp]
      rung = check_rung(advice, 1)
      call check(rung%step > 3 .and. .not. rung%stretches, 'what bends is verified')
      rung = strained_rung(advice, 1)
      call check(.not. rung%stretches, 'strain of no effect is not')
      advice%rungs%step = 0
      rung = check_rung(advice, 1)
      call check(rung%step == 0, 'a rigid beam of no effect is not verified')
      call note_surprise(advice, 20.0e-6_wp)
      rung = check_rung(advice, 1)
      call check(rung%step > 0, '20 times as much: it is')
      advice%rungs%step = 3
      ! Twice the stretch, 2e-6, is to be a tenth of the share over 0.65 of it, 1e-3: 500 times
      call note_surprise(advice, 400.0e-6_wp)
      call check_close(advice%surprise, 400.0_wp, 1.0e-12_wp, 'errors over what was expected')
      rung = strained_rung(advice, 1)
      call check(.not. rung%stretches, '400 times as much: functions are verified')
      call note_surprise(advice, 600.0e-6_wp)
      rung = strained_rung(advice, 1)
      call check(rung%step == 3 .and. rung%stretches, '600 times as much: strain is verified')
      call note_surprise(advice, 1.0e-6_wp)
      call check_close(advice%surprise, 600.0_wp, 1.0e-12_wp, 'a surprise is not forgotten')
      call note_surprise(advice, huge(1.0_wp))
      call check_close(advice%surprise, 600.0_wp, 1.0e-12_wp, 'a run that failed tells nothing')
   end subroutine test_surprise

   !> A mass on a spring moves as 1 + cos(t). Its runs are kept: none is made twice, and the tolerance nearest to one that is asked
   !> for is found between bounds.
   subroutine test_kept_runs()
      type(deck_type) :: deck
      type(pool_type) :: pool
      type(candidate_type) :: trial
      type(run_request_type) :: request
      type(error_type), allocatable :: error
      call read(deck, '*POINT MASS, NAME=bob, MASS=1, X=2'//nl//'*JOINT, NAME=rail, TYPE=POINT ON LINE'//nl// &
         & ' bob, ground.origin'//nl// &
         & '*SPRING, NAME=s, STIFFNESS=1, LENGTH=1'//nl//' bob, ground.origin'//nl// &
         & '*DYNAMICS, END=10, OUTPUTS=20, INTEGRATOR=RADAU'// &
         & nl//'*OUTPUT'//nl//' x(bob)'//nl)
      pool%deck = deck
      allocate (request%rungs(0))
      request%label = 'run'
      request%wide = .true.
      request%tolerance = 1.0e-4_wp
      call pool%run(request, trial, error)
      call check_no_error(error, 'a loose run')
      request%wide = .false.
      request%tolerance = 1.0e-8_wp
      call pool%run(request, trial, error)
      call check_no_error(error, 'a fine run')
      call check(error_of(trial) < 1.0e-6_wp, 'it moves as 1 + cos(t)')
      request%tolerance = 1.0e-4_wp
      call pool%run(request, trial, error)
      call check(pool%runs == 2 .and. error_of(trial) > 1.0e-9_wp, 'a run that is there is not made again')
      request%tolerance = 1.0e-7_wp
      call check_close(pool%kept_tolerance(request, [1.0e-9_wp, 1.0e-3_wp]), 1.0e-8_wp, 1.0e-20_wp, 'the nearer one')
      call check_close(pool%kept_tolerance(request, [1.0e-7_wp, 1.0e-3_wp]), 1.0e-4_wp, 1.0e-16_wp, 'within the bounds')
      request%tolerance = 1.0e-6_wp
      call check_close(pool%kept_tolerance(request, [1.0e-7_wp, 1.0e-5_wp]), 1.0e-6_wp, 1.0e-18_wp, 'none is there')
   end subroutine test_kept_runs

   !> Largest difference from 1 + cos(t).
   real(wp) function error_of(trial)
      type(candidate_type), intent(in) :: trial
      integer :: k
      error_of = 0.0_wp
      do k = 1, trial%samples%samples
         error_of = max(error_of, abs(trial%samples%values(1, k) - 1 - cos(0.5_wp*(k - 1))))
      end do
   end function error_of

   !> A bar that turns at a constant speed stretches by rho omega^2 L^3/(3 E) = 0.005 of its length at rest, and at most twice
   !> that from a sudden start. A run of the bar's own functions shows it, and it counts as an error of the reference.
   subroutine test_strain()
      real(wp), parameter :: stretch = 5.0e-3_wp
      type(deck_type) :: deck
      type(target_search_type) :: s
      type(run_request_type) :: request
      type(error_type), allocatable :: error
      call read(deck, '*PARAMETER'//nl//' density = 1000, speed = 15, young = density*speed**2/0.015'//nl// &
         & '*MATERIAL, NAME=m, YOUNG=young, DENSITY=density'//nl//'*SECTION, NAME=s, SHAPE=CIRCLE, DIAMETER=0.1'//nl// &
         & '*BEAM, NAME=bar, MATERIAL=m, SECTION=s, LENGTH=1'//nl//'*JOINT, NAME=pin, TYPE=REVOLUTE'//nl// &
         & ' bar.start, ground.origin'// &
         & nl//'*DRIVER, NAME=motor, TYPE=ANGLE, BODY=bar'//nl//' speed*t'//nl// &
         & '*DYNAMICS, END=0.4, OUTPUTS=100, INTEGRATOR=RADAU'//nl// &
         & '*OUTPUT'//nl//' reach = 1 + u1(bar.end)'//nl)
      s%pool%deck = deck
      s%target = 1.0_wp
      associate (advice => s%reached%advice)
         call find_rungs(deck, advice%rungs)
         allocate (advice%probe%beams(1))
         advice%probe%blind = .true.
         advice%tolerance = 1.0e-4_wp
         advice%target = s%target
         advice%share = s%target
         advice%expected = [0.0_wp]
         request%rungs = advice%rungs
         request%tolerance = advice%tolerance
         request%label = 'run'
         request%wide = .true.
         call s%pool%run(request, s%candidate, error)
         call check_no_error(error, 'a bar without strain')
         s%reference%scale = s%candidate%scale
         s%reference%of_terms = s%candidate%of_terms
         s%reference%finest = s%candidate%samples%values(:1, :) - stretch
         s%reference%of_time = [0.0_wp]
         s%reference%tolerance = advice%tolerance
         s%reference%rungs = advice%rungs
         s%evidence%time_known = .true.
         s%evidence%model_known = .true.
         call weigh(s)
         call check(s%evidence%asks_strain .and. s%evidence%can_strain, 'the strain is to be measured')
         call strain_step(s, error)
         call check_no_error(error, 'its strain')
         call check(s%pool%runs == 2 .and. s%evidence%strain_known, 'by one run')
         call check(abs(s%reference%of_strain(1) - 2*stretch) < 0.1_wp*stretch, 'the stretch is an error of the reference')
         s%target = 0.0_wp
         call weigh(s)
         call check(abs(s%reached%error - 3*stretch) < 0.1_wp*stretch, 'beside the difference from that')
      end associate
   end subroutine test_strain

   !> A beam between two pins or two walls cannot bend without strain; a hinged one and a cantilever can.
   subroutine test_held_beams()
      character(*), parameter :: start = '*JOINT, NAME=a, TYPE=REVOLUTE'//nl//' bar.start, ground.origin'//nl, &
         & end = '*JOINT, NAME=b, TYPE=REVOLUTE'//nl//' bar.end, ground.far'//nl, &
         & wall = '*JOINT, NAME=a, TYPE=WELD'//nl//' bar.start, ground.origin'//nl, &
         & other = '*JOINT, NAME=b, TYPE=WELD'//nl//' bar.end, ground.far'//nl
      type(level_type) :: rung
      rung = rung_of(start)
      call check(rung%least == 0 .and. rung%enough == 5, 'hinged: no strain, five functions verify')
      rung = rung_of(start//end)
      call check(rung%least == 1, 'between pins: with strain')
      rung = rung_of(wall//other)
      call check(rung%least == 1, 'between walls: with strain')
      rung = rung_of(wall//'*FORCE, NAME=f, POINT=bar.middle'//nl//' 0, -1'//nl)
      call check(rung%least == 0 .and. rung%enough == 6, 'a force within: a function more verifies')
   end subroutine test_held_beams

   !> The rung of a bar under what holds it.
   type(level_type) function rung_of(held)
      character(*), intent(in) :: held
      type(deck_type) :: deck
      type(scene_type) :: scene
      type(level_type), allocatable :: rungs(:)
      type(error_type), allocatable :: error
      call read(deck, '*MATERIAL, NAME=steel, YOUNG=2e11, DENSITY=7850'//nl//'*SECTION, NAME=s, SHAPE=CIRCLE, DIAMETER=0.02'//nl// &
         & '*BEAM, NAME=bar, MATERIAL=steel, SECTION=s, LENGTH=1'//nl//'*GROUND'//nl//' far, 1, 0'//nl//held//'*GRAVITY'//nl// &
         & '*DYNAMICS, END=0.1'//nl//'*OUTPUT'//nl//' y(bar.middle)'//nl)
      call find_rungs(deck, rungs)
      call build_exact(deck, rungs, scene, error)
      call check_no_error(error, held)
      rung_of = rungs(1)
   end function rung_of

   subroutine read(deck, text)
      type(deck_type), intent(out) :: deck
      character(*), intent(in) :: text
      type(diagnostics_type) :: diagnostics
      call read_deck_text('scene.inp', text, deck, diagnostics)
   end subroutine read

end program test_verification
