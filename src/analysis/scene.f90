!> From a deck's path to a system at its first state: deck -> model -> modes -> system -> assembly. Errors come back
!> as text that points into the deck. Floor: analysis.
module limber_analysis_scene
   use limber_base_kinds, only: wp, long
   use limber_base_error, only: error_type, raise, status_deck
   use limber_base_text, only: newline
   use limber_analysis_choice, only: choose_integrator
   use limber_deck_content, only: deck_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_origin, only: origin_type
   use limber_deck_reader, only: read_deck
   use limber_model_build, only: build_model
   use limber_model_scene, only: model_type
   use limber_system_assembly, only: first_guess, assemble
   use limber_system_system, only: system_type, workspace_type, new_system, new_workspace
   implicit none
   private
   public :: scene_type, read_scene, build_scene, seconds_since

   !> A scene ready to be analysed
   type :: scene_type
      type(deck_type) :: deck
      type(system_type) :: system
      type(workspace_type) :: work
      !> Assembled coordinates and velocities at the first time (nq)
      real(wp), allocatable :: q(:), v(:)
      !> Rendered warnings, one after another; empty if there are none
      character(:), allocatable :: warnings
      !> Wall seconds for reading the deck, for building model and modes, and for the assembly
      real(wp) :: reading = 0.0_wp, building = 0.0_wp, assembling = 0.0_wp
   end type scene_type

contains

   !> Reads, builds and assembles.
   subroutine read_scene(path, scene, error)
      !> The deck
      character(*), intent(in) :: path
      type(scene_type), intent(out) :: scene
      !> Everything that is wrong with the deck, rendered; status 2
      type(error_type), allocatable, intent(out) :: error
      type(diagnostics_type) :: diagnostics
      integer(long) :: tick
      call system_clock(tick)
      call read_deck(path, scene%deck, diagnostics)
      scene%reading = seconds_since(tick)
      call build_scene(scene, diagnostics, error)
   end subroutine read_scene

   !> Builds and assembles what the deck of the scene describes.
   subroutine build_scene(scene, diagnostics, error)
      !> With its deck; receives the rest
      type(scene_type), intent(inout) :: scene
      !> Of the reading of the deck
      type(diagnostics_type), intent(inout) :: diagnostics
      !> Everything that is wrong with the deck, rendered; status 2
      type(error_type), allocatable, intent(out) :: error
      type(model_type) :: model
      integer(long) :: tick
      call system_clock(tick)
      call build_model(scene%deck, model, diagnostics)
      scene%building = seconds_since(tick)
      if (diagnostics%count == 0) then
         call system_clock(tick)
         scene%system = new_system(model)
         call new_workspace(scene%system, scene%work)
         call assemble_scene(scene, diagnostics)
         scene%assembling = seconds_since(tick)
         if (diagnostics%count == 0) call settle_integrator(scene)
      end if
      scene%warnings = diagnostics%render(scene%deck%source)
      if (diagnostics%count > 0) call raise(error, scene%warnings, status_deck)
      if (diagnostics%warnings > 0) scene%warnings = scene%warnings//newline
   end subroutine build_scene

   !> Chooses the integrator where the deck leaves it open.
   subroutine settle_integrator(scene)
      type(scene_type), intent(inout) :: scene
      character(:), allocatable :: integrator, reason
      if (.not. scene%system%model%dynamics%wanted) return
      if (scene%system%model%dynamics%integrator /= 'AUTO') return
      call choose_integrator(scene%system, scene%work, scene%q, scene%v, integrator, reason)
      scene%system%model%dynamics%integrator = integrator
      scene%system%model%dynamics%reason = reason
   end subroutine settle_integrator

   !> First state; what cannot be assembled is shown at the joint or driver in the deck.
   subroutine assemble_scene(scene, diagnostics)
      type(scene_type), intent(inout) :: scene
      type(diagnostics_type), intent(inout) :: diagnostics
      type(error_type), allocatable :: error
      integer :: culprit, block
      allocate (scene%q(scene%system%layout%nq), scene%v(scene%system%layout%nq))
      associate (model => scene%system%model)
         call first_guess(scene%system, model%dynamics%start, scene%q, scene%v)
         call assemble(scene%system, scene%work, model%dynamics%start, scene%q, scene%v, error, culprit)
         if (.not. allocated(error)) return
         if (culprit <= size(model%joints)) then
            block = scene%deck%find_named('JOINT', model%joints(culprit)%name)
         else
            block = scene%deck%find_named('DRIVER', model%drivers(culprit - size(model%joints))%name)
         end if
         if (block > 0) then
            call diagnostics%add(scene%deck%blocks(block)%origin_of('NAME'), error%message)
         else
            call diagnostics%add(origin_type(file=1), error%message)
         end if
      end associate
   end subroutine assemble_scene

   !> Wall seconds since a reading of `system_clock`.
   real(wp) function seconds_since(tick) result(seconds)
      !> Clock then [ticks]
      integer(long), intent(in) :: tick
      integer(long) :: now, rate
      call system_clock(now, rate)
      seconds = real(now - tick, wp)/real(rate, wp)
   end function seconds_since

end module limber_analysis_scene
