!> Whether the functions of exact beams follow the bending near ends and loads under much tension: the bending moment there by
!> equilibrium against the one that a layer of the length sqrt(E I/N) makes, which follows from the section forces alone.
!> Floor: analysis. Source: doc/theory, section "The exact beam", eqs. (N1), (N2).
module limber_analysis_layer_watch
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   use limber_base_text, only: as_text, newline
   use limber_analysis_function_watch, only: function_watch_type
   use limber_flex_exact, only: exact_type, angles_at, lean_at, panel_stations
   use limber_flex_exact_functions, only: sorted
   use limber_flex_exact_profile, only: of_ei, of_ea
   use limber_model_scene, only: model_type
   use limber_system_algebra, only: turned_by => turn
   use limber_system_system, only: system_type
   implicit none
   private
   public :: layer_watch_type, start_layers, observe_layers, join_layers, layer_warnings

   !> Tension from which on eq. (N1) is close enough, in units of E I/L^2
   real(wp), parameter :: much = 1000.0_wp
   !> Part of the largest moment that may be wrong; angles that are too small to count [rad]
   real(wp), parameter :: allowed = 0.05_wp, least_angle = 1.0e-7_wp
   !> How far the layers of the functions may be from that of the tension
   real(wp), parameter :: alike = 1.3_wp

   !> A side of a place that a layer may spread from
   type :: side_type
      !> Coordinate; 1: what lies behind it, -1: before it
      real(wp) :: at = 0.0_wp, side = 1.0_wp
      !> The station next to it, and the other end of its panel
      integer :: next = 0, far = 0
      !> Angles of the functions there (angles), and of the undeformed axis
      real(wp), allocatable :: psi(:)
      real(wp) :: lean = 0.0_wp
   end type side_type

   !> One beam
   type :: beam_layers_type
      integer :: body = 0
      type(side_type), allocatable :: sides(:)
      !> Largest moment in the layers, largest error, when and where that was, and the tension there
      real(wp) :: moment = 0.0_wp, error = 0.0_wp, when = 0.0_wp, at = 0.0_wp, tension = 0.0_wp
   end type beam_layers_type

   !> All exact beams, in the order of the watch of their functions
   type :: layer_watch_type
      type(beam_layers_type), allocatable :: beams(:)
   contains
      procedure :: exchange
   end type layer_watch_type

contains

   !> Begins to watch.
   subroutine start_layers(self, system, functions)
      type(layer_watch_type), intent(out) :: self
      type(system_type), intent(in) :: system
      type(function_watch_type), intent(in) :: functions
      real(wp), allocatable :: places(:)
      logical :: at_end(2)
      integer :: i, k, n
      allocate (self%beams(size(functions%beams)))
      do i = 1, size(self%beams)
         self%beams(i)%body = functions%beams(i)%body
         associate (exact => system%model%bodies(self%beams(i)%body)%reduced%exact, &
            & choice => system%model%bodies(self%beams(i)%body)%choice%exact)
            ! A curved axis has no straight layers
            if (abs(exact%arc) > 0.0_wp) then
               allocate (self%beams(i)%sides(0))
               cycle
            end if
            if (allocated(places)) deallocate (places)
            allocate (places, source=sorted([choice%kinks, choice%steps], exact%total))
            ! Where nothing makes a moment at an end there is none
            at_end = choice%layered .and. choice%moment
            allocate (self%beams(i)%sides(count(at_end) + 2*size(places)))
            associate (sides => self%beams(i)%sides)
               n = 0
               if (at_end(1)) call add_side(exact, 0.0_wp, 1, n, sides)
               do k = 1, size(places)
                  call add_side(exact, places(k), -1, n, sides)
                  call add_side(exact, places(k), 1, n, sides)
               end do
               if (at_end(2)) call add_side(exact, exact%total, -1, n, sides)
            end associate
         end associate
      end do
   end subroutine start_layers

   !> A side of a place, which is the end of a panel.
   pure subroutine add_side(exact, at, direction, n, sides)
      type(exact_type), intent(in) :: exact
      !> Coordinate of the place [length]
      real(wp), intent(in) :: at
      !> 1: behind it, -1: before it
      integer, intent(in) :: direction
      !> Number of sides so far
      integer, intent(inout) :: n
      type(side_type), intent(inout) :: sides(:)
      integer :: panel
      n = n + 1
      associate (side => sides(n))
         side%at = at
         side%side = direction
         panel = minloc(abs([(sum(exact%panel(:panel)), panel=0, size(exact%panel))] - at), dim=1)
         ! Panels before the place: panel - 1
         if (direction > 0) then
            side%next = (panel - 1)*panel_stations + 1
            side%far = panel*panel_stations
         else
            side%next = (panel - 1)*panel_stations
            side%far = (panel - 2)*panel_stations + 1
         end if
         side%psi = angles_at(exact, at)
         side%lean = lean_at(exact, at)
      end associate
   end subroutine add_side

   !> Takes in a state, with the section forces that the watch of the functions has found at it.
   subroutine observe_layers(self, functions, system, t, q)
      type(layer_watch_type), intent(inout) :: self
      type(function_watch_type), intent(in) :: functions
      type(system_type), intent(in) :: system
      !> Time, coordinates (nq)
      real(wp), intent(in) :: t, q(:)
      integer :: i, k, first
      do i = 1, size(self%beams)
         first = system%layout%q(self%beams(i)%body) + 4
         associate (exact => system%model%bodies(self%beams(i)%body)%reduced%exact)
            do k = 1, size(self%beams(i)%sides)
               call look(self%beams(i), exact, self%beams(i)%sides(k), functions%beams(i)%effort%exact, t, &
                  & q(first:first - 1 + exact%n))
            end do
         end associate
      end do
   end subroutine observe_layers

   !> The moment at one place by equilibrium against that of the layer, eqs. (N1), (N2).
   pure subroutine look(self, exact, side, forces, t, eta)
      type(beam_layers_type), intent(inout) :: self
      type(exact_type), intent(in) :: exact
      type(side_type), intent(in) :: side
      !> Axial force, shear force and moment at the stations (3, stations); time; coordinates (n)
      real(wp), intent(in) :: forces(:, :), t, eta(:)
      real(wp) :: near(2), far(2), slope(2), force(2), distance, layer, stretch, layered, moment, own
      associate (a => exact%angles, ei => exact%section(of_ei, side%next), ea => exact%section(of_ea, side%next))
         ! Quick, for beams without much tension
         if (.not. forces(1, side%next)*exact%total**2 > 0.5_wp*much*ei) return
         own = side%lean + dot_product(side%psi, eta(:a))
         near = in_axes(side%next)
         far = in_axes(side%far)
         slope = (far - near)/(exact%s(side%far) - exact%s(side%next))
         distance = exact%s(side%next) - side%at
         force = near - distance*slope
         if (.not. force(1)*exact%total**2 > much*ei) return
         stretch = 1 + max(-0.5_wp, force(1)/ea)
         layer = sqrt(ei/(force(1)*stretch))
         layered = side%side*layer*stretch*force(2) + layer**2*(slope(2) - 0.75_wp*force(2)*slope(1)/force(1))
         moment = forces(3, side%next) + 0.5_wp*distance*stretch*(force(2) + forces(2, side%next))
         self%moment = max(self%moment, abs(layered), least_angle*force(1)*layer)
         if (.not. abs(moment - layered) > self%error) return
         self%error = abs(moment - layered)
         self%when = t
         self%at = side%at
         self%tension = force(1)
      end associate

   contains

      !> The internal force at a station, in the axes of the section at the place.
      pure function in_axes(station) result(force)
         integer, intent(in) :: station
         real(wp) :: force(2), angle
         angle = exact%lean(station) + dot_product(exact%psi(:, station), eta(:exact%angles)) - own
         associate (axis => [cos(angle), sin(angle)])
            force = forces(1, station)*axis + forces(2, station)*turned_by(axis)
         end associate
      end function in_axes

   end subroutine look

   !> Joins what an analysis has seen to that of those before.
   subroutine join_layers(part, whole)
      type(layer_watch_type), intent(in) :: part
      type(layer_watch_type), intent(inout) :: whole
      integer :: i
      do i = 1, size(whole%beams)
         associate (beam => whole%beams(i), own => part%beams(i))
            beam%moment = max(beam%moment, own%moment)
            if (own%error <= beam%error) cycle
            beam%error = own%error
            beam%when = own%when
            beam%at = own%at
            beam%tension = own%tension
         end associate
      end do
   end subroutine join_layers

   !> A warning for each beam whose moments err.
   function layer_warnings(self, model, times) result(text)
      type(layer_watch_type), intent(in) :: self
      type(model_type), intent(in) :: model
      !> How many times beyond its limit an error must be
      real(wp), intent(in) :: times
      character(:), allocatable :: text
      integer :: i
      text = ''
      do i = 1, size(self%beams)
         if (self%beams(i)%error <= times*allowed*self%beams(i)%moment) cycle
         text = text//warning_of(self%beams(i), model)
      end do
   end function layer_warnings

   function warning_of(self, model) result(text)
      type(beam_layers_type), intent(in) :: self
      type(model_type), intent(in) :: model
      character(:), allocatable :: text
      real(wp) :: tautness
      associate (body => model%bodies(self%body), exact => model%bodies(self%body)%reduced%exact)
         tautness = self%tension*exact%total**2/body%beam%ei
         text = "warning: beam '"//body%name//"': a tension of "//as_text(self%tension, 3)//' ('//as_text(tautness, 2)// &
            & ' E I/L^2) bends it near '//place_words(self%at, exact%total)//' within '// &
            & as_text(1/sqrt(tautness), 2)//' of its length, which its functions cannot follow: moments and reactions there '// &
            & 'err by about '//as_text(100*self%error/self%moment, 2)//' % of the largest at t = '//as_text(self%when, 4)// &
            & '; '//remedy()//newline
      end associate

   contains

      function remedy()
         character(:), allocatable :: remedy
         associate (choice => model%bodies(self%body)%choice%exact)
            remedy = 'use TENSION='//as_text(self%tension, 2)
            if (model%bodies(self%body)%whole > 0) then
               if (allocated(model%wholes(model%bodies(self%body)%whole)%lean)) &
                  & remedy = 'write this member as a *BEAM with TENSION='//as_text(self%tension, 2)
            end if
            if (.not. allocated(choice%layers)) return
            if (size(choice%layers) == 0) return
            if (choice%layers(1) < alike*sqrt(model%bodies(self%body)%beam%ei/self%tension)) &
               & remedy = 'use FUNCTIONS='//as_text(2*choice%angles)
         end associate
      end function remedy

   end function warning_of

   function place_words(at, length) result(text)
      real(wp), intent(in) :: at, length
      character(:), allocatable :: text
      text = 's = '//as_text(at, 4)
      if (.not. at > 0.0_wp) text = 'its start'
      if (.not. at < length) text = 'its end'
   end function place_words

   !> Saves or restores it.
   subroutine exchange(self, snapshot)
      class(layer_watch_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      integer :: i
      do i = 1, size(self%beams)
         call snapshot%exchange('layer_moment', self%beams(i)%moment)
         call snapshot%exchange('layer_error', self%beams(i)%error)
         call snapshot%exchange('layer_when', self%beams(i)%when)
         call snapshot%exchange('layer_at', self%beams(i)%at)
         call snapshot%exchange('layer_tension', self%beams(i)%tension)
      end do
   end subroutine exchange

end module limber_analysis_layer_watch
