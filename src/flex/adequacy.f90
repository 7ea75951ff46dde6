!> What the coordinates of a flexible body hold of its statics: the flexibility that they leave out where something acts on it,
!> and their shares in the energy that a load stores. A straight beam comes as a frame of one member (`beam_frame`). Used before
!> the time loop only, to choose a basis and to warn of one. Floor: flex. Source: doc/theory, eqs. (135), (136).
module limber_flex_adequacy
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_flex_frame, only: frame_type
   use limber_flex_frame_solver, only: solver_type, new_solver, solve_static
   use limber_flex_functions, only: attachment_type, attachment_loads
   implicit none
   private
   public :: static_residual, participation

contains

   !> Displacements of attachments under unit loads there: those of the mesh, and what the coordinates leave out of them,
   !> eq. (135). Of a body that is free they are those beside the rigid motion.
   subroutine static_residual(frame, shape, omega2, attachments, whole, left_out, error)
      type(frame_type), intent(in) :: frame
      !> Shapes (3, nodes, n) and squared circular frequencies (n) of the coordinates
      real(wp), intent(in) :: shape(:, :, :), omega2(:)
      type(attachment_type), intent(in) :: attachments(:)
      !> [length/force], [1/(force length)] of couples; zero where the supports take the load (attachments)
      real(wp), intent(out) :: whole(:), left_out(:)
      !> The supports do not hold the body
      type(error_type), allocatable, intent(out) :: error
      type(solver_type) :: solver
      real(wp) :: load(3, size(frame%place, 2), size(attachments)), u(3, size(frame%place, 2))
      integer :: i
      whole = 0.0_wp
      left_out = 0.0_wp
      call new_solver(frame, solver, error)
      if (allocated(error)) return
      load = attachment_loads(frame, attachments)
      do i = 1, size(attachments)
         call solve_static(frame, solver, load(:, :, i), u)
         whole(i) = sum(load(:, :, i)*u)
         left_out(i) = whole(i) - sum(modal_forces(load(:, :, i), shape)**2/omega2)
      end do
   end subroutine static_residual

   !> Shares of the coordinates in the energy that a load stores at rest, eq. (136).
   subroutine participation(frame, shape, omega2, load, share, left_out, error)
      type(frame_type), intent(in) :: frame
      !> Shapes (3, nodes, n) and squared circular frequencies (n) of the coordinates
      real(wp), intent(in) :: shape(:, :, :), omega2(:)
      !> Forces and couples on the nodes, in any scale (3, nodes)
      real(wp), intent(in) :: load(:, :)
      !> Of each coordinate (n), and what no coordinate has; their sum is 1, or 0 of a load that stores nothing
      real(wp), intent(out) :: share(:), left_out
      !> The supports do not hold the body
      type(error_type), allocatable, intent(out) :: error
      type(solver_type) :: solver
      real(wp) :: u(3, size(load, 2)), energy
      share = 0.0_wp
      left_out = 0.0_wp
      call new_solver(frame, solver, error)
      if (allocated(error)) return
      call solve_static(frame, solver, merge(load, 0.0_wp, frame%free), u)
      energy = sum(load*u)
      if (.not. energy > 0.0_wp) return
      share = modal_forces(load, shape)**2/(omega2*energy)
      left_out = 1.0_wp - sum(share)
   end subroutine participation

   !> Forces that a load exerts on coordinates (n).
   pure function modal_forces(load, shape) result(force)
      real(wp), intent(in) :: load(:, :), shape(:, :, :)
      real(wp) :: force(size(shape, 3))
      integer :: j
      do j = 1, size(force)
         force(j) = sum(load*shape(:, :, j))
      end do
   end function modal_forces

end module limber_flex_adequacy
