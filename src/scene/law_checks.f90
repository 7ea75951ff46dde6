!> Checks of laws of time before a run. Those without a value somewhere are refused, for no step can pass a pole or end of a root;
!> and the instants at which steps must end. Floor: scene. Source: doc/theory, eqs. (5.43), (5.44).
module limber_scene_law_checks
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use limber_deck_content, only: deck_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_expression, only: expression_type
   use limber_deck_origin, only: origin_type
   use limber_scene_outcome, only: outcome_type, warn
   use limber_model_law_breaks, only: undefined_at, find_breaks, find_stations
   use limber_model_model, only: model_type
   use limber_multibody_kinematics, only: kinematics_type
   use limber_multibody_motion_laws, only: describe_law
   use limber_multibody_system, only: system_type
   implicit none
   private
   public :: check_laws, find_instants, check_law_energies

contains

   !> Errors at the drivers and loads whose laws are not defined throughout the dynamic analysis.
   subroutine check_laws(model, deck, diagnostics)
      type(model_type), intent(in) :: model
      type(deck_type), intent(in) :: deck
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: i, j
      do i = 1, size(model%drivers)
         call check_law(model%drivers(i)%law, 'DRIVER|MOTION', model%drivers(i)%name)
      end do
      do i = 1, size(model%loads)
         do j = model%loads(i)%first, model%loads(i)%last
            associate (part => model%load_parts(j))
               if (part%driven .and. part%is_of_time()) &
                  & call check_law(part%law, 'FORCE|TORQUE|SPRING|DISTRIBUTED LOAD', model%loads(i)%name)
            end associate
         end do
      end do
      do j = 1, size(model%load_parts)
         associate (part => model%load_parts(j))
            if (part%control > 0 .and. part%is_of_time()) call check_law(part%law, 'CONTROL', &
               & model%controls(max(1, part%control))%name)
         end associate
      end do

   contains

      subroutine check_law(law, keywords, name)
         type(expression_type), intent(in) :: law
         character(*), intent(in) :: keywords, name
         type(origin_type) :: origin
         real(wp) :: t
         integer :: block
         t = undefined_at(law, model%dynamics%start, model%dynamics%end)
         if (t > model%dynamics%end) return
         origin = origin_type(file=1)
         block = deck%find_named(keywords, name)
         ! The drivers of a motion are <motion>_x, _y and _angle
         if (block == 0 .and. index(name, '_') > 0) block = deck%find_named('MOTION', name(:index(name, '_', back=.true.) - 1))
         if (block > 0) origin = deck%blocks(block)%origin_of('NAME')
         call diagnostics%add(origin, "the law of '"//name//"' has no value, or grows without bound, at t = "//as_text(t, 8), &
            & 'let END= come before that, or write a law that is finite throughout')
      end subroutine check_law

   end subroutine check_laws

   !> Breaks and stations of all laws, and a warning where there are more.
   subroutine find_instants(model, breaks, stations, outcome)
      type(model_type), intent(in) :: model
      real(wp), allocatable, intent(out) :: breaks(:), stations(:)
      type(outcome_type), intent(inout) :: outcome
      character(:), allocatable :: restless
      call find_breaks(model, breaks, restless)
      if (len(restless) > 0) call warn(outcome, "the law of '"//restless//"' changes its formula too often: "// &
         & as_text(size(breaks))//' changes are met'//up_to(breaks)//', steps may pass over others; let END= come'// &
         & ' earlier, or write a law with fewer bends and jumps')
      call find_stations(model, stations, restless)
      if (len(restless) > 0) call warn(outcome, "the law of '"//restless//"' has more short pulses than steps are led to"// &
         & up_to(stations)//': others may be passed over; let END= come earlier, or write a law with fewer pulses')

   contains

      function up_to(times) result(text)
         real(wp), intent(in) :: times(:)
         character(:), allocatable :: text
         text = ''
         if (size(times) > 0) text = ' up to t = '//as_text(times(size(times)), 6)
      end function up_to

   end subroutine find_instants

   !> A warning, once, if the energy of a law is not known at a sample of an analysis that has no balance of energy.
   subroutine check_law_energies(system, kinematics, t, outcome)
      type(system_type), intent(in) :: system
      !> Placed; and the time
      type(kinematics_type), intent(in) :: kinematics
      real(wp), intent(in) :: t
      type(outcome_type), intent(inout) :: outcome
      !> Part of an energy that it may be off by
      real(wp), parameter :: allowed = 0.01_wp
      real(wp) :: energy, doubt
      integer :: i
      if (outcome%unsure) return
      do i = 1, size(system%loads)
         doubt = system%loads(i)%item%energy_doubt(kinematics)
         if (.not. doubt > 0.0_wp) cycle
         energy = 0.0_wp
         call system%loads(i)%item%add_energy(kinematics, energy)
         if (doubt <= allowed*abs(energy)) cycle
         outcome%unsure = .true.
         call warn(outcome, describe_law(system, i)//' comes and goes too often for its integral: at t = '//as_text(t, 8)// &
            & ' the energy '//as_text(energy, 3)//', which potential_energy(system) and the work take from it, may be off by '// &
            & as_text(doubt, 2)//'; write a law with fewer bends')
         return
      end do
   end subroutine check_law_energies

end module limber_scene_law_checks
