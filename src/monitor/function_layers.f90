!> Monitor of bending layers of taut exact beams. By equilibrium, against the one that a layer of the length sqrt(E I/N) makes,
!> which follows from the section forces alone. Floor: monitor. Source: doc/theory, part 2, eqs. (7.70), (7.71).
module limber_monitor_function_layers
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   use limber_beam_exact_beam, only: exact_type, angles_at, lean_at, panel_stations
   use limber_beam_exact_functions, only: sorted
   use limber_beam_exact_profile, only: of_ei, of_ea
   use limber_model_model, only: body_type
   use limber_multibody_plane_vectors, only: turned_by => turn
   implicit none
   private
   public :: layers_type, start_layers, observe_layers, join_layers, lost_in_layers

   !> Tension from which on eq. (7.70) is close enough, in units of E I/L^2
   real(wp), parameter :: much = 1000.0_wp
   !> Angles that are too small to count [rad]
   real(wp), parameter :: least_angle = 1.0e-7_wp

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
   type :: layers_type
      type(side_type), allocatable :: sides(:)
      !> Largest moment in the layers, largest error, when and where that was, and the tension there
      real(wp) :: moment = 0.0_wp, error = 0.0_wp, when = 0.0_wp, at = 0.0_wp, tension = 0.0_wp
   contains
      procedure :: exchange => exchange_layers
   end type layers_type

contains

   !> Begins to watch.
   subroutine start_layers(self, body)
      type(layers_type), intent(out) :: self
      type(body_type), intent(in) :: body
      real(wp), allocatable :: places(:)
      logical :: at_end(2)
      integer :: k, n
      associate (exact => body%reduced%exact, choice => body%choice%exact)
         ! A curved axis has no straight layers
         if (abs(exact%arc) > 0.0_wp) then
            allocate (self%sides(0))
            return
         end if
         allocate (places, source=sorted([choice%kinks, choice%steps], exact%total))
         ! Where nothing makes a moment at an end there is none
         at_end = choice%layered .and. choice%moment
         allocate (self%sides(count(at_end) + 2*size(places)))
         n = 0
         if (at_end(1)) call add_side(exact, 0.0_wp, 1, n, self%sides)
         do k = 1, size(places)
            call add_side(exact, places(k), -1, n, self%sides)
            call add_side(exact, places(k), 1, n, self%sides)
         end do
         if (at_end(2)) call add_side(exact, exact%total, -1, n, self%sides)
      end associate
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

   !> Takes in a state.
   pure subroutine observe_layers(self, exact, t, eta, forces)
      type(layers_type), intent(inout) :: self
      type(exact_type), intent(in) :: exact
      !> Time; coordinates (n)
      real(wp), intent(in) :: t, eta(:)
      !> Axial force, shear force, bending moment by equilibrium (3, stations)
      real(wp), intent(in) :: forces(:, :)
      integer :: k
      do k = 1, size(self%sides)
         call look(self, exact, self%sides(k), t, eta, forces)
      end do
   end subroutine observe_layers

   !> The moment at one place by equilibrium against that of the layer, eqs. (7.70), (7.71).
   pure subroutine look(self, exact, side, t, eta, forces)
      type(layers_type), intent(inout) :: self
      type(exact_type), intent(in) :: exact
      type(side_type), intent(in) :: side
      real(wp), intent(in) :: t, eta(:), forces(:, :)
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

   !> Bending moment that is off, as a part of the largest one in the layers.
   pure real(wp) function lost_in_layers(self) result(lost)
      type(layers_type), intent(in) :: self
      lost = 0.0_wp
      if (self%moment > 0.0_wp) lost = self%error/self%moment
   end function lost_in_layers

   !> Joins what an analysis has seen to that of those before.
   pure subroutine join_layers(part, whole)
      type(layers_type), intent(in) :: part
      type(layers_type), intent(inout) :: whole
      whole%moment = max(whole%moment, part%moment)
      if (part%error <= whole%error) return
      whole%error = part%error
      whole%when = part%when
      whole%at = part%at
      whole%tension = part%tension
   end subroutine join_layers

   !> Saves or restores it.
   subroutine exchange_layers(self, snapshot)
      class(layers_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      call snapshot%exchange('layer_moment', self%moment)
      call snapshot%exchange('layer_error', self%error)
      call snapshot%exchange('layer_when', self%when)
      call snapshot%exchange('layer_at', self%at)
      call snapshot%exchange('layer_tension', self%tension)
      ! Not saved: sides
   end subroutine exchange_layers

end module limber_monitor_function_layers
