!> Static solutions of a plane frame with a banded stiffness. Used before the time loop only. Floor: beam. Source: doc/theory, eqs.
!> (2.1), (2.12).
module limber_beam_frame_solver
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type, raise
   use limber_base_finite, only: dsyev, dpbtrf, dpbtrs
   use limber_base_text, only: as_text
   use limber_beam_plane_frame, only: frame_type, element_stiffness
   implicit none
   private
   public :: solver_type, new_solver, solve_static, frame_band, rigid_motions, on_equations, from_equations, project, &
      & remove_motion
   public :: connected_nodes

   !> The factored stiffness of the degrees of freedom that are free
   type :: solver_type
      !> Number of the equation of x, y and rotation of each node; 0: held (3, nodes)
      integer, allocatable :: number(:, :)
      !> Equations, bandwidth
      integer :: n = 0, width = 0
      !> Cholesky factor, lower band
      real(wp), allocatable :: factor(:, :)
      !> Rigid motions that the supports leave, orthonormal in the mass (3, nodes, number)
      real(wp), allocatable :: motion(:, :, :)
   end type solver_type

contains

   !> Which nodes hang together with the first.
   pure function connected_nodes(frame) result(connected)
      type(frame_type), intent(in) :: frame
      logical :: connected(size(frame%place, 2))
      integer :: order(size(connected)), count
      call sort_nodes(frame, order, count)
      connected = .false.
      connected(order(:count)) = .true.
   end function connected_nodes

   !> Nodes in an order that keeps those that are joined near each other (Cuthill and McKee), from the first one's neighbourhood.
   pure subroutine sort_nodes(frame, order, count)
      type(frame_type), intent(in) :: frame
      !> The nodes that hang together with the first (nodes), so many of them
      integer, intent(out) :: order(:), count
      integer :: start(size(order) + 1), neighbour(2*size(frame%member)), fill(size(order)), e, k, i, j, swap
      logical :: seen(size(order))
      start = 0
      do e = 1, size(frame%member)
         start(frame%ends(:, e) + 1) = start(frame%ends(:, e) + 1) + 1
      end do
      start(1) = 1
      do i = 1, size(order)
         start(i + 1) = start(i + 1) + start(i)
      end do
      fill = start(:size(order))
      do e = 1, size(frame%member)
         do k = 1, 2
            neighbour(fill(frame%ends(k, e))) = frame%ends(3 - k, e)
            fill(frame%ends(k, e)) = fill(frame%ends(k, e)) + 1
         end do
      end do
      seen = .false.
      order = 0
      ! The walk begins at the far end of another one, from the first node
      do k = 1, 2
         swap = 1
         if (k == 2) swap = order(count)
         seen = .false.
         order(1) = swap
         seen(swap) = .true.
         count = 1
         i = 0
         do while (i < count)
            i = i + 1
            do j = start(order(i)), start(order(i) + 1) - 1
               if (seen(neighbour(j))) cycle
               count = count + 1
               order(count) = neighbour(j)
               seen(neighbour(j)) = .true.
            end do
         end do
      end do
   end subroutine sort_nodes

   !> Numbers of the equations of the free degrees of freedom.
   pure subroutine number_equations(frame, number, n)
      type(frame_type), intent(in) :: frame
      !> (3, nodes); 0: held
      integer, intent(out) :: number(:, :), n
      integer :: order(size(number, 2)), count, i, k
      call sort_nodes(frame, order, count)
      n = 0
      number = 0
      do i = 1, count
         do k = 1, 3
            if (.not. frame%free(k, order(i))) cycle
            n = n + 1
            number(k, order(i)) = n
         end do
      end do
   end subroutine number_equations

   !> Stiffness of the free degrees of freedom as a lower band, and their numbers.
   pure subroutine frame_band(frame, number, band)
      type(frame_type), intent(in) :: frame
      !> Equations (3, nodes); 0: held
      integer, allocatable, intent(out) :: number(:, :)
      !> (1 + width, n)
      real(wp), allocatable, intent(out) :: band(:, :)
      real(wp) :: k(6, 6)
      integer :: place(6), n, width, e, i, j
      allocate (number(3, size(frame%place, 2)))
      call number_equations(frame, number, n)
      width = 0
      do e = 1, size(frame%member)
         place = [number(:, frame%ends(1, e)), number(:, frame%ends(2, e))]
         do i = 1, 6
            do j = 1, 6
               if (place(i) > 0 .and. place(j) > 0) width = max(width, place(i) - place(j))
            end do
         end do
      end do
      allocate (band(1 + width, n))
      band = 0.0_wp
      do e = 1, size(frame%member)
         k = element_stiffness(frame, e)
         place = [number(:, frame%ends(1, e)), number(:, frame%ends(2, e))]
         do j = 1, 6
            if (place(j) == 0) cycle
            do i = 1, 6
               if (place(i) >= place(j)) band(1 + place(i) - place(j), place(j)) = band(1 + place(i) - place(j), place(j)) + k(i, j)
            end do
         end do
      end do
   end subroutine frame_band

   !> The motions without strain that the supports leave (3, nodes, number), orthonormal in the mass.
   subroutine rigid_motions(frame, motion)
      type(frame_type), intent(in) :: frame
      real(wp), allocatable, intent(out) :: motion(:, :, :)
      real(wp) :: all(3, size(frame%place, 2), 3), gram(3, 3), value(3), work(24), centre(2), extent
      integer :: i, j, k, info, count
      do k = 1, 2
         centre(k) = sum(frame%mass(k, :)*frame%place(k, :))/sum(frame%mass(k, :))
      end do
      extent = maxval(abs(frame%place - spread(centre, 2, size(frame%place, 2))))
      all = 0.0_wp
      all(1, :, 1) = 1.0_wp
      all(2, :, 2) = 1.0_wp
      all(1, :, 3) = -(frame%place(2, :) - centre(2))/extent
      all(2, :, 3) = (frame%place(1, :) - centre(1))/extent
      all(3, :, 3) = 1.0_wp/extent
      do i = 1, 3
         do j = 1, 3
            gram(i, j) = sum(all(1:2, :, i)*all(1:2, :, j), mask=.not. frame%free(1:2, :)) &
               & + extent**2*sum(all(3, :, i)*all(3, :, j), mask=.not. frame%free(3, :))
         end do
      end do
      call dsyev('V', 'L', 3, gram, 3, value, work, size(work), info)
      count = 0
      if (info == 0) count = merge(3, 0, maxval(value) <= 0.0_wp)
      if (count == 0) then
         do i = 1, 3
            if (value(i) <= 1.0e-12_wp*maxval(value)) count = i
         end do
      end if
      allocate (motion(3, size(frame%place, 2), count))
      do j = 1, count
         motion(:, :, j) = all(:, :, 1)*gram(1, j) + all(:, :, 2)*gram(2, j) + all(:, :, 3)*gram(3, j)
         where (.not. frame%free) motion(:, :, j) = 0.0_wp
         do i = 1, j - 1
            motion(:, :, j) = motion(:, :, j) - motion(:, :, i)*sum(frame%mass*motion(:, :, i)*motion(:, :, j))
         end do
         motion(:, :, j) = motion(:, :, j)/sqrt(sum(frame%mass*motion(:, :, j)**2))
      end do
   end subroutine rigid_motions

   !> The free entries of a field on the nodes, in the order of the equations.
   pure function on_equations(number, field) result(vector)
      integer, intent(in) :: number(:, :)
      real(wp), intent(in) :: field(:, :)
      real(wp) :: vector(maxval(number))
      integer :: i, k
      do i = 1, size(number, 2)
         do k = 1, 3
            if (number(k, i) > 0) vector(number(k, i)) = field(k, i)
         end do
      end do
   end function on_equations

   !> The way back; zero where held.
   pure function from_equations(number, vector) result(field)
      integer, intent(in) :: number(:, :)
      real(wp), intent(in) :: vector(:)
      real(wp) :: field(3, size(number, 2))
      integer :: i, k
      field = 0.0_wp
      do i = 1, size(number, 2)
         do k = 1, 3
            if (number(k, i) > 0) field(k, i) = vector(number(k, i))
         end do
      end do
   end function from_equations

   !> Factors the stiffness; of free rigid motions so many degrees of freedom are held that none is left.
   subroutine new_solver(frame, solver, error)
      type(frame_type), intent(in) :: frame
      type(solver_type), intent(out) :: solver
      type(error_type), allocatable, intent(out) :: error
      real(wp), allocatable :: rows(:, :)
      integer :: k, row, i, info
      real(wp) :: unit(3)
      call frame_band(frame, solver%number, solver%factor)
      call rigid_motions(frame, solver%motion)
      solver%n = size(solver%factor, 2)
      solver%width = size(solver%factor, 1) - 1
      allocate (rows(size(solver%motion, 3), solver%n))
      do k = 1, size(rows, 1)
         rows(k, :) = on_equations(solver%number, solver%motion(:, :, k))
      end do
      do k = 1, size(rows, 1)
         row = maxloc(sum(rows**2, dim=1), dim=1)
         unit(:size(rows, 1)) = rows(:, row)/norm2(rows(:, row))
         do i = 1, solver%n
            rows(:, i) = rows(:, i) - unit(:size(rows, 1))*dot_product(unit(:size(rows, 1)), rows(:, i))
         end do
         ! Held: nothing is left of its row and column but the diagonal
         solver%factor(2:, row) = 0.0_wp
         do i = max(1, row - solver%width), row - 1
            solver%factor(1 + row - i, i) = 0.0_wp
         end do
         where (solver%number == row) solver%number = -row
      end do
      call dpbtrf('L', solver%n, solver%width, solver%factor, solver%width + 1, info)
      if (info /= 0) call raise(error, 'the stiffness matrix under these supports is not positive definite (row '// &
         & as_text(info)//')')
   end subroutine new_solver

   !> The displacements that loads on the nodes make, at rest, or, as far as rigid motions are free, in the motion that the
   !> loads give the frame without strain; then without a rigid part. Loads that only move it make none.
   subroutine solve_static(frame, solver, load, u)
      type(frame_type), intent(in) :: frame
      type(solver_type), intent(in) :: solver
      !> Forces and couples (3, nodes)
      real(wp), intent(in) :: load(:, :)
      !> (3, nodes)
      real(wp), intent(out) :: u(:, :)
      real(wp) :: balanced(3, size(load, 2)), vector(solver%n)
      integer :: k, i, info
      balanced = load
      do k = 1, size(solver%motion, 3)
         balanced = balanced - frame%mass*solver%motion(:, :, k)*sum(solver%motion(:, :, k)*load)
      end do
      u = 0.0_wp
      if (size(solver%motion, 3) > 0 .and. is_round_off(frame, balanced, load)) return
      vector = 0.0_wp
      do i = 1, size(load, 2)
         do k = 1, 3
            if (solver%number(k, i) > 0) vector(solver%number(k, i)) = balanced(k, i)
         end do
      end do
      call dpbtrs('L', solver%n, solver%width, 1, solver%factor, solver%width + 1, vector, solver%n, info)
      u = from_equations(max(0, solver%number), vector)
      call remove_motion(frame, solver, u)
   end subroutine solve_static

   !> Whether what is left of loads is round-off.
   pure logical function is_round_off(frame, rest, load)
      type(frame_type), intent(in) :: frame
      !> Forces and couples (3, nodes)
      real(wp), intent(in) :: rest(:, :), load(:, :)
      !> Part of the loads
      real(wp), parameter :: none = 1.0e-12_wp
      real(wp) :: force, extent
      extent = maxval(maxval(frame%place, dim=2) - minval(frame%place, dim=2))
      force = max(maxval(abs(load(1:2, :))), maxval(abs(load(3, :)))/extent)
      is_round_off = max(maxval(abs(rest(1:2, :))), maxval(abs(rest(3, :)))/extent) <= none*force
   end function is_round_off

   !> Takes the rigid motions that the supports leave out of a field.
   pure subroutine remove_motion(frame, solver, field)
      type(frame_type), intent(in) :: frame
      type(solver_type), intent(in) :: solver
      !> (3, nodes)
      real(wp), intent(inout) :: field(:, :)
      integer :: k
      do k = 1, size(solver%motion, 3)
         call project(frame%mass, solver%motion(:, :, k), field)
      end do
   end subroutine remove_motion

   !> Takes the part along a direction of unit mass out of a field.
   pure subroutine project(mass, direction, field)
      !> (3, nodes) each
      real(wp), intent(in) :: mass(:, :), direction(:, :)
      real(wp), intent(inout) :: field(:, :)
      field = field - direction*sum(mass*direction*field)
   end subroutine project

end module limber_beam_frame_solver
