!> Scenes of the pilot run. They have all open beams exact, with vibration modes, and rigid. Floor: accuracy; deck + rungs -> deck
!> or scene. Equations: doc/theory, part 7.
module limber_accuracy_pilot_scenes
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_accuracy_fidelity_levels, only: level_type, apply_rung
   use limber_scene_first_scene, only: build_scene
   use limber_scene_scene, only: scene_type
   use limber_deck_content, only: deck_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_families, only: options_of_exact
   use limber_beam_exact_functions, only: sorted
   use limber_model_model, only: body_flexible
   implicit none
   private
   public :: build_exact, probe_modally, make_rigid, build

   !> Coordinates that a probe gives a beam: bending modes, and behind them axial ones
   integer, parameter, public :: probe_modes = 6
   integer, parameter :: probe_axial = 3

contains

   !> The scene with the functions of the third rung, and none of strain. Where joints hold beams so that they cannot bend then,
   !> with one of that as well, which every rung has from then on; the lowest rung is the first that the joints let bend.
   subroutine build_exact(deck, rungs, scene, error)
      type(deck_type), intent(in) :: deck
      type(level_type), intent(inout) :: rungs(:)
      type(scene_type), intent(out) :: scene
      type(error_type), allocatable, intent(out) :: error
      integer, parameter :: third = 3
      integer :: i, least, step
      do least = 0, 1
         call build_rungs(deck, rungs, third, least, scene, error)
         if (.not. allocated(error)) exit
         if (.not. any(rungs%open_strains)) return
      end do
      if (allocated(error)) return
      if (least == 1) then
         where (rungs%open_strains) rungs%least = 1
         do step = 1, third
            call build_rungs(deck, rungs, step, least, scene, error)
            if (.not. allocated(error)) exit
         end do
         where (rungs%open_functions) rungs%lowest = max(rungs%lowest, step)
         where (rungs%open_functions) rungs%step = max(rungs%step, step)
      end if
      do i = 1, size(rungs)
         rungs(i)%enough = enough_functions(scene, deck%blocks(rungs(i)%block)%name())
      end do
   end subroutine build_exact

   !> The scene with all beams on a rung, as far as the deck leaves them open.
   subroutine build_rungs(deck, rungs, step, least, scene, error)
      type(deck_type), intent(in) :: deck
      type(level_type), intent(in) :: rungs(:)
      !> Place in the ladder; least functions of the strain
      integer, intent(in) :: step, least
      type(scene_type), intent(out) :: scene
      !> It cannot be built so
      type(error_type), allocatable, intent(out) :: error
      type(level_type) :: rung
      integer :: i
      scene%deck = deck
      do i = 1, size(rungs)
         rung = rungs(i)
         if (rung%open_functions) rung%step = max(rung%lowest, step)
         rung%step = max(1, rung%step)
         if (rung%open_strains) rung%least = least
         call apply_rung(rung, scene%deck)
      end do
      call build(scene, error)
   end subroutine build_rungs

   !> Functions of the angle from which on a beam can be trusted to show what fewer lack: those of what acts within it, which serve
   !> beside linear moments only, and two modes with as many polynomials.
   integer function enough_functions(scene, name) result(enough)
      type(scene_type), intent(in) :: scene
      !> Of the beam
      character(*), intent(in) :: name
      integer, parameter :: beside = 5
      integer :: i
      enough = beside
      do i = 1, size(scene%system%model%bodies)
         associate (body => scene%system%model%bodies(i))
            if (body%name /= name .or. body%kind /= body_flexible) cycle
            if (allocated(body%choice%exact%kinks)) enough = enough + size(sorted(body%choice%exact%kinks, body%beam%length))
            if (allocated(body%choice%exact%steps)) enough = enough + size(sorted(body%choice%exact%steps, body%beam%length))
         end associate
      end do
   end function enough_functions

   !> A beam of a deck with vibration modes, for its probe, under the support that its joints make.
   subroutine probe_modally(exact, rung, deck)
      !> With the beam as exact
      type(scene_type), intent(in) :: exact
      type(level_type), intent(in) :: rung
      type(deck_type), intent(inout) :: deck
      character(15) :: support
      character(8) :: start
      integer :: i
      call drop_features(rung%block, deck)
      call deck%set_option(rung%block, 'GEOMETRIC', 'K_G', given=.true.)
      call deck%set_number(rung%block, 'BENDING MODES', real(probe_modes, wp), given=.true.)
      call deck%set_number(rung%block, 'AXIAL MODES', real(probe_axial, wp), given=.true.)
      if (deck%blocks(rung%block)%integer('SEGMENTS') > 1) call deck%set_number(rung%block, 'SEGMENTS', 1.0_wp)
      if (deck%blocks(rung%block)%given('SUPPORT')) return
      do i = 1, size(exact%system%model%bodies)
         associate (body => exact%system%model%bodies(i))
            if (body%name /= deck%blocks(rung%block)%name() .or. body%kind /= body_flexible) cycle
            associate (held => body%choice%exact%support)
               start = 'FREE-'
               if (held%w_start) start = 'PINNED-'
               if (held%theta_start) start = 'CLAMPED-'
               if (held%theta_end) then
                  support = trim(start)//'CLAMPED'
               else if (held%w_end) then
                  support = trim(start)//'ROLLER'
               else
                  support = trim(start)//'FREE'
               end if
            end associate
            if (any(support == ['CLAMPED-FREE   ', 'PINNED-ROLLER  ', 'CLAMPED-ROLLER ', 'CLAMPED-CLAMPED', 'FREE-FREE      '])) &
               & call deck%set_option(rung%block, 'SUPPORT', trim(support), given=.true.)
         end associate
      end do
   end subroutine probe_modally

   !> A rigid beam of a deck.
   subroutine make_rigid(rung, deck)
      type(level_type), intent(in) :: rung
      type(deck_type), intent(inout) :: deck
      call drop_features(rung%block, deck)
      call deck%set_option(rung%block, 'GEOMETRIC', 'RIGID', given=.true.)
      call deck%set_number(rung%block, 'SEGMENTS', 1.0_wp)
   end subroutine make_rigid

   !> Takes from a beam what only an exact one has; a probe does without.
   subroutine drop_features(place, deck)
      integer, intent(in) :: place
      type(deck_type), intent(inout) :: deck
      integer :: i
      do i = 1, size(deck%blocks(place)%options)
         associate (option => deck%blocks(place)%options(i))
            if (any(options_of_exact == option%name)) option%given = .false.
         end associate
      end do
      do i = 1, size(deck%blocks)
         if (deck%blocks(i)%keyword == 'PROFILE') deck%blocks(i)%keyword = 'STUDY'
      end do
   end subroutine drop_features

   !> A scene of its deck.
   subroutine build(scene, error)
      type(scene_type), intent(inout) :: scene
      type(error_type), allocatable, intent(out) :: error
      type(diagnostics_type) :: diagnostics
      call build_scene(scene, diagnostics, error)
   end subroutine build

end module limber_accuracy_pilot_scenes
